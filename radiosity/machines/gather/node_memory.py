"""Memory of a node: what its patches, its hemicube and its rows take."""

from dataclasses import dataclass
from typing import ClassVar

from golden.base.errors import InputError
from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["PATCH_WORDS", "SIDE", "SQUARES", "NodeMemory"]

SIDE = 50
SQUARES = 3 * (2 * SIDE) ** 2
"""Squares along half an edge of a hemicube, and of all its five faces: the source's typical one."""

PATCH_WORDS = 24
"""Words of a patch: 4 corners, normal, area, reflectances, emissions, number, and corners that differ."""

_WORD, _ENTRY_WORDS, _ROW_WORDS, _SQUARE_WORDS = 4, 2, 2, 2


@dataclass(frozen=True, kw_only=True)
class NodeMemory(TimingNumbers):
    """Bytes of a node, with words of 4 bytes; an entry of a row has a column and a value, a square a patch and a depth.

    The source has 4 MB and is silent on the rest. With 1 MiB for the system and the program, exactly those of its
    scenes fit that it has times of.

    Parameters
    ----------
    size
        Bytes of the memory.
    reserved
        Bytes of it that the system and the program take.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below 0, or the memory is empty.

    Source: Kurc 1997, section 2.3.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("size",)

    size: int = 4 << 20
    reserved: int = 1 << 20

    def free(self, patches: int) -> int:
        """Bytes for rows beside a hemicube and so many patches.

        Raises
        ------
        InputError
            There are none.
        """
        free = self.size - self.reserved - _WORD * (_SQUARE_WORDS * SQUARES + PATCH_WORDS * patches)
        if free <= 0:
            raise InputError(f"gather: Memory must be more than {self.size - free} bytes for a node with {patches} "
                             f"patches and no row, not {self.size}", parameter="memory")
        return free

    @staticmethod
    def row_bytes(entries):
        """Bytes of rows of so many entries, a number or an array."""
        return _WORD * (_ENTRY_WORDS * entries + _ROW_WORDS)
