"""Fully associative placement, least frequently used."""

import numpy as np

from golden.errors import InputError

__all__ = ["LfuPlacement"]


class LfuPlacement:
    """Any line; the one goes that has been used least often since it was filled.

    The first use counts 1; a count stays at 2^``count_bits`` - 1. An empty line has count 0, so empty lines are filled
    first. Of lines with equal counts the first one goes after the line that was filled last, round and round.

    Parameters
    ----------
    lines
        Any number from 1.
    count_bits
        Of a counter.
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
        """See `golden.memsys.cache.Cache.access`."""
        keys = np.asarray(keys, dtype=np.int64).tolist()
        hit, line, victim = np.zeros(len(keys), dtype=bool), np.empty(len(keys), np.int64), np.full(len(keys), -1)
        for number, key in enumerate(keys):
            place = self._line.get(key)
            if place is None:
                victim[number], place = self._fill(key)
            else:
                hit[number] = True
                self._count[place] = min(self._count[place] + 1, self._top)
            line[number] = place
        return hit, line, victim

    def _fill(self, key):
        """The key that goes, and the line."""
        # From the next line on to the end, and round.
        place = (int(np.roll(self._count, -self._next).argmin()) + self._next) % self._lines
        gone = int(self._key[place])
        self._line.pop(gone, None)
        self._line[key], self._key[place], self._count[place] = place, key, 1
        self._next = (place + 1) % self._lines
        return gone, place
