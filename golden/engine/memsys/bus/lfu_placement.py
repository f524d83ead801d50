"""Fully associative placement, least frequently used."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["LfuPlacement"]


class LfuPlacement:
    """Any line holds any key; the line used least often since it was filled is evicted.

    The first use counts 1; a count stays at 2^``count_bits`` - 1. An empty line has count 0, so empty lines are filled
    first. Among equal counts the first line after the last one filled is evicted, cyclically.

    Parameters
    ----------
    lines
        Lines, at least 1.
    count_bits
        Bits of a counter, at least 1.
    """

    def __init__(self, *, lines: int, count_bits: int):
        if lines < 1 or count_bits < 1:
            raise InputError(f"cache: Lines and count bits must be at least 1, not {lines!r} and {count_bits!r}")
        self._lines, self._top = lines, (1 << count_bits) - 1
        self.clear()

    def clear(self) -> None:
        """Empty all lines; the first one is filled next."""
        self._line, self._key = {}, np.full(self._lines, -1)
        self._count = np.zeros(self._lines, dtype=np.int64)
        self._next = 0

    def access(self, keys) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See `golden.engine.memsys.bus.cache.Cache.access`."""
        keys = np.asarray(keys, dtype=np.int64).tolist()
        hit, line, victim = np.zeros(len(keys), dtype=bool), np.empty(len(keys), np.int64), np.full(len(keys), -1)
        for number, key in enumerate(keys):
            slot = self._line.get(key)
            if slot is None:
                victim[number], slot = self._fill(key)
            else:
                hit[number] = True
                self._count[slot] = min(self._count[slot] + 1, self._top)
            line[number] = slot
        return hit, line, victim

    def _fill(self, key):
        """Evict a key and store another: the evicted key, and the line."""
        # Cyclic order from the next line.
        slot = (int(np.roll(self._count, -self._next).argmin()) + self._next) % self._lines
        evicted = int(self._key[slot])
        self._line.pop(evicted, None)
        self._line[key], self._key[slot], self._count[slot] = slot, key, 1
        self._next = (slot + 1) % self._lines
        return evicted, slot
