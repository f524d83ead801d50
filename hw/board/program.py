"""Program: what the sequencer does, step by step."""

from dataclasses import dataclass

from amaranth.lib import enum

__all__ = ["Operation", "Program", "Step"]


class Operation(enum.Enum, shape=3):
    """The operation of a step on its address and its value."""

    # Write the value to the register at the address.
    WRITE = 0
    # Continue with the program's part for errors unless the register at the address holds the value.
    EXPECT = 1
    # Wait for the interrupt, acknowledge it, and read the status at the address; again while the machine is busy, once
    # the queue has halted without an interrupt. Continue with the program's part for errors if the machine has failed.
    WAIT = 2
    # Start a frame: the value is kind and length.
    FRAME = 3
    # Send the register at the address.
    WORD = 4
    # Send bytes of main memory from the address on; the value is their number.
    BYTES = 5
    # End the frame.
    CHECK = 6
    # Stop, until a restart from the first step on.
    HALT = 7


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of a program."""

    operation: Operation
    address: int = 0
    value: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Program:
    """Steps, and the initial contents of main memory.

    Parameters
    ----------
    steps
        The normal part and the part for errors; each ends with HALT.
    error
        Number of the first step of the part for errors.
    memory
        From address 0 on.
    """

    steps: tuple[Step, ...]
    error: int
    memory: bytes
