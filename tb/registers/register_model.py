"""What the registers of a table hold and answer, by the table's meaning."""

from hw.registers.axi_lite_signature import DATA_BITS
from hw.registers.register import ALIGNMENT, WORD_BYTES, Access, Register, addresses
from hw.registers.registers import OKAY, SLVERR

__all__ = ["RegisterModel"]


class RegisterModel:
    """Registers that are written and read one access after the other.

    Parameters
    ----------
    registers
        The table.
    memory_bits
        Of addresses of main memory.

    Members
    -------
    held
        Values of the registers that the host writes.
    words
        By number each word that is part of a register: the register, and which of its words.
    """

    def __init__(self, registers: tuple[Register, ...], *, memory_bits: int = 64):
        self._memory_bits = memory_bits
        self.held = {one.name: one.reset for one in registers if one.access is Access.WRITE}
        first = {name: address // WORD_BYTES for name, address in addresses(registers).items()}
        self.words = {first[one.name] + word: (one, word) for one in registers for word in range(one.words)}

    def write(self, address: int, data: int, strobe: int) -> tuple[int, tuple[str, int] | None]:
        """The answer, and a command if it is one."""
        register, word = self.words.get(address // WORD_BYTES, (None, 0))
        if register is None or register.access is Access.READ:
            return SLVERR, None
        mask = sum(0xFF << 8 * byte for byte in range(WORD_BYTES) if strobe >> byte & 1)
        fits = (1 << register.width) - 1
        if register.access in (Access.COMMAND, Access.CONTROL):
            return OKAY, (register.name, data & mask & fits) if strobe else None
        given = (data & mask) << DATA_BITS * word
        value = self.held[register.name] & ~(mask << DATA_BITS * word) | given
        if register.is_address:
            is_legal = given % ALIGNMENT == 0 and given < 1 << self._memory_bits
        else:
            is_legal = given <= fits and (register.most is None or value <= register.most)
        if not is_legal:
            return SLVERR, None
        self.held[register.name] = value
        return OKAY, None

    def read(self, address: int, machine: dict[str, int]) -> dict[str, int]:
        """The answer, given what the machine's registers are."""
        register, word = self.words.get(address // WORD_BYTES, (None, 0))
        if register is None:
            return {"data": 0, "resp": SLVERR}
        value = (self.held | machine).get(register.name, 0)
        return {"data": value >> DATA_BITS * word & (1 << DATA_BITS) - 1, "resp": OKAY}
