"""Ray memory of a shadow frustum: which rays are blocked."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.frustum.shadow_record import ShadowRecord

__all__ = ["ShadowMemory"]


class ShadowMemory:
    """Any hit before a ray's end blocks it, so the order of updates does not matter.

    A ray's stored inverse distance begins as that of its end. A hit with a larger one makes it the largest number: no
    patch improves a blocked ray, and no shell holds more of it.

    Parameters
    ----------
    record
        The frustum.
    config
        The configuration.

    Members
    -------
    inverse
        R int64, the stored inverse distance of each ray.
    blocked
        R bool.

    Raises
    ------
    InputError
        More rays than ``icu.rays``.
    """

    def __init__(self, record: ShadowRecord, config: Config):
        if len(record) > config.icu.rays:
            raise InputError(f"frustum: Rays must be at most icu.rays ({config.icu.rays}), not {len(record)}")
        self._settled = config.numbers.inverse.high
        self.inverse, self.blocked = record.end.copy(), np.zeros(len(record), dtype=bool)

    def update(self, ray: np.ndarray, inverse: np.ndarray, _patch: np.ndarray) -> None:
        """Add hits: ray and stored inverse distance of each; a ray may occur several times."""
        ray = ray[inverse > self.inverse[ray]]
        self.inverse[ray], self.blocked[ray] = self._settled, True
