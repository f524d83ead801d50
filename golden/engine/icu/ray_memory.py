"""Ray memory and nearest update: the best hit of each ray."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config

__all__ = ["RayMemory"]

_LAST_PATCH = (1 << 31) - 1


class RayMemory:
    """The largest 1/t wins, and the smallest patch id among equal ones; the order of updates does not matter.

    Both form one integer, 1/t above the complement of the id: an update is one read, one comparison and one write.

    Parameters
    ----------
    rays
        Rays of the frustum, at most ``icu.rays``.
    config
        The configuration.

    Raises
    ------
    InputError
        More rays than the memory holds.
    """

    def __init__(self, rays: int, config: Config):
        if rays > config.icu.rays:
            raise InputError(f"frustum: Rays must be at most icu.rays ({config.icu.rays}), not {rays}")
        self._key = np.zeros(rays, dtype=np.int64)

    def update(self, ray: np.ndarray, inverse: np.ndarray, patch: np.ndarray) -> None:
        """Add hits: ray, stored inverse distance (not 0) and patch of each; a ray may occur several times."""
        np.maximum.at(self._key, ray, (inverse << 31) | (_LAST_PATCH - patch))

    @property
    def inverse(self) -> np.ndarray:
        """Stored inverse distance of each ray, 0 for none."""
        return self._key >> 31

    @property
    def patch(self) -> np.ndarray:
        """Patch of each ray as int64, -1 for none."""
        return np.where(self._key > 0, _LAST_PATCH - (self._key & _LAST_PATCH), -1)
