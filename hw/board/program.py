"""Program: what the sequencer does, step by step."""

from dataclasses import dataclass

from amaranth.lib import enum

__all__ = ["Operation", "Program", "Step"]


class Operation(enum.Enum, shape=3):
    """What a step does with its address and its value."""

    # Write the value to the register at the address.
    WRITE = 0
    # Go on with the program's error part unless the register at the address holds the value.
    EXPECT = 1
    # Read the status at the address until the machine has nothing to do; likewise if it then says that it has failed.
    WAIT = 2
    # Begin a frame: the value is kind and length.
    FRAME = 3
    # Send the register at the address.
    WORD = 4
    # Send as many bytes of main memory as the value says, from the address on.
    BYTES = 5
    # End the frame.
    CHECK = 6
    # Stop until somebody wants it again, from the first step on.
    HALT = 7


@dataclass(frozen=True, kw_only=True)
class Step:
    """One of them."""

    operation: Operation
    address: int = 0
    value: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Program:
    """Steps, and main memory before them.

    Parameters
    ----------
    steps
        Of the usual part and of that for errors; each ends with HALT.
    error
        Number of the first step of the part for errors.
    memory
        From address 0 on.
    """

    steps: tuple[Step, ...]
    error: int
    memory: bytes
