"""Scene pages: where the cells, lists and patches of a scene are in the shared memory."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_int
from golden.scene.cells import Cells

__all__ = ["CELL_BYTES", "LIST_BYTES", "PATCH_BYTES", "ScenePages", "check_page_bytes"]

CELL_BYTES, LIST_BYTES, PATCH_BYTES = 8, 4, 128
"""Bytes of a cell, which points to its list; of an entry of a list, which points to a patch; and of a patch: 4 corners,
normal, reflectances, emission, number, and pointers. The source has no layout."""


def check_page_bytes(page_bytes: int) -> None:
    """A page has as many bytes as a patch or a larger power of two.

    Raises
    ------
    TypeError
        They are no int.
    InputError
        They are no such number.
    """
    check_int("koan: Page bytes", page_bytes)
    if page_bytes < PATCH_BYTES or page_bytes & (page_bytes - 1):
        raise InputError(f"koan: Page bytes must be a power of two from {PATCH_BYTES}, not {page_bytes!r}",
                         parameter="page_bytes")


@dataclass(frozen=True, kw_only=True)
class ScenePages:
    """Three regions of shared memory, each of whole pages: cells, lists, patches.

    Parameters
    ----------
    cells, entries, patches
        Numbers of cells, of entries of all lists, and of patches.
    page_bytes
        Bytes of a page, a power of two from 128.

    Raises
    ------
    TypeError
        The bytes are no int.
    InputError
        They are no such power of two.

    Source: Badouel 1991, sections 3.1 and 4.3.
    """

    cells: int
    entries: int
    patches: int
    page_bytes: int

    def __post_init__(self):
        check_page_bytes(self.page_bytes)

    @classmethod
    def of(cls, cells: Cells, patches: int, page_bytes: int) -> "ScenePages":
        """The regions of a scene in these cells."""
        return cls(cells=len(cells), entries=len(cells.patch), patches=patches, page_bytes=page_bytes)

    @property
    def first(self) -> np.ndarray:
        """4 int64: the first page of each region, and their number."""
        sizes = (self.cells * CELL_BYTES, self.entries * LIST_BYTES, self.patches * PATCH_BYTES)
        return np.cumsum([0, *(-(-size // self.page_bytes) for size in sizes)])

    def __len__(self) -> int:
        return int(self.first[-1])

    @property
    def size(self) -> int:
        """Bytes of the regions."""
        return self.cells * CELL_BYTES + self.entries * LIST_BYTES + self.patches * PATCH_BYTES
