"""Registers as a table, from which hardware, page and driver are generated."""

import enum
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import accumulate

from hw.registers.axi_lite_signature import DATA_BITS

__all__ = ["ALIGNMENT", "Access", "Field", "Register", "addresses", "register_table"]

WORD_BYTES = DATA_BITS // 8
# What an address in a register is a multiple of.
ALIGNMENT = 64


class Access(enum.Enum):
    """Who writes a register."""

    READ = "read"
    WRITE = "write, read"
    COMMAND = "command"
    CONTROL = "command, read"


@dataclass(frozen=True, kw_only=True)
class Field:
    """Some bits of a register.

    Parameters
    ----------
    name, width, about
        As a Python name, bits, meaning.
    clears
        Of a CONTROL register: writing 1 clears it.
    """

    name: str
    width: int
    about: str
    clears: bool = False


@dataclass(frozen=True, kw_only=True)
class Register:
    """One register.

    Parameters
    ----------
    name
        As a Python name.
    access
        READ: the machine. WRITE: the host, which reads what it has written. COMMAND: each write is one; reads as 0.
        CONTROL: each write is a command, the host reads a value of the machine.
    about
        Its meaning.
    width
        Bits; of more than 32 the low word comes first, and writes take effect word by word.
    fields
        From bit 0 on, without gaps; none: one number.
    reset
        The reset value of a WRITE register.
    is_address
        A WRITE register has the address of a table: a multiple of `ALIGNMENT` within main memory.
    most
        The largest value of a WRITE register of one word. Default: all that its bits can hold.

    Raises
    ------
    ValueError
        The width is out of range, the fields do not fit, or the host does not write what has a rule.
    """

    name: str
    access: Access
    about: str
    width: int = DATA_BITS
    fields: tuple[Field, ...] = ()
    reset: int = 0
    is_address: bool = False
    most: int | None = None

    def __post_init__(self):
        if not 1 <= self.width <= 2 * DATA_BITS:
            raise ValueError(f"Width must be from 1 to {2 * DATA_BITS}, not {self.width!r}")
        if (bits := sum(field.width for field in self.fields)) > self.width:
            raise ValueError(f"Fields of {self.name} must have at most {self.width} bits, not {bits}")
        if self.access in (Access.COMMAND, Access.CONTROL) and self.width > DATA_BITS:
            raise ValueError(f"Width of a command must be at most {DATA_BITS}, not {self.width!r}")
        if (self.is_address or self.most is not None) and self.access is not Access.WRITE:
            raise ValueError(f"Access of {self.name} must be WRITE, as it has a rule, not {self.access.name}")

    @property
    def words(self) -> int:
        """How many words it takes."""
        return -(-self.width // DATA_BITS)

    @property
    def placed(self) -> Iterator[tuple[Field, int]]:
        """The fields, each with its lowest bit."""
        return zip(self.fields, accumulate((field.width for field in self.fields), initial=0), strict=False)

    def ones(self, memory_bits: int) -> int:
        """The bits that a write may set, with addresses of main memory of so many bits."""
        if self.is_address:
            return (1 << min(self.width, memory_bits)) - ALIGNMENT
        return (1 << self.width) - 1

    @property
    def rule(self) -> str:
        """What a written value must be, in words; empty: any that fits."""
        if self.is_address:
            return f"A multiple of {ALIGNMENT} below 2^`memory.address_bits`."
        return "" if self.most is None else f"At most {self.most}."

    def pack(self, **fields: int) -> int:
        """The value with these fields, the others 0.

        Raises
        ------
        KeyError
            There is no such field.
        ValueError
            A number is out of range.
        """
        value, known = 0, dict(fields)
        for field, low in self.placed:
            part = known.pop(field.name, 0)
            if not 0 <= part < 1 << field.width:
                raise ValueError(f"{self.name}.{field.name} must be from 0 to {(1 << field.width) - 1}, not {part!r}")
            value |= part << low
        if known:
            raise KeyError(f"there is no {', '.join(known)} in {self.name}")
        return value

    def unpack(self, value: int) -> dict[str, int]:
        """The fields of a value."""
        return {field.name: value >> low & (1 << field.width) - 1 for field, low in self.placed}


def addresses(registers: Iterable[Register]) -> dict[str, int]:
    """The address of each register's first word: one after the other from 0 on.

    Raises
    ------
    ValueError
        Two registers have the same name, or one of two words is not at a multiple of their bytes.
    """
    found, address = {}, 0
    for register in registers:
        if register.name in found:
            raise ValueError(f"Names of registers must differ, not be {register.name} twice")
        if address % (WORD_BYTES * register.words):
            raise ValueError(f"Address of {register.name} must be a multiple of its bytes, not {address:#x}")
        found[register.name] = address
        address += WORD_BYTES * register.words
    return found


def register_table(registers: Iterable[Register]) -> str:
    """All of them as Markdown."""
    registers = tuple(registers)
    known = addresses(registers)
    lines = ["| address | register | bits | access | meaning |", "|---|---|---|---|---|"]
    for register in registers:
        rule = f" {register.rule}" if register.rule else ""
        reset = f" Reset: {register.reset}." if register.reset else ""
        lines.append(f"| {known[register.name]:#05x} | `{register.name}` | {register.width} | "
                     f"{register.access.value} | {register.about}{rule}{reset} |")
        for field, low in register.placed:
            bits = f"{low}" if field.width == 1 else f"{low + field.width - 1}:{low}"
            lines.append(f"| | `.{field.name}` | {bits} | | {field.about} |")
    return "\n".join(lines) + "\n"
