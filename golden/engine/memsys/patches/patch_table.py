"""The patch address table: the patch lists of all cells, one after the other."""

import numpy as np

__all__ = ["PatchTable"]


class PatchTable:
    """Patch numbers by address.

    Parameters
    ----------
    patch
        E int, patch numbers; the cell address table points into them.
    """

    def __init__(self, patch: np.ndarray):
        self._patch = np.ascontiguousarray(patch, dtype=np.int32)

    def __len__(self) -> int:
        return len(self._patch)

    def read(self, addresses: np.ndarray) -> np.ndarray:
        """The patches at the addresses."""
        return self._patch[addresses]
