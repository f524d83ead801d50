"""Direct and set-associative placement."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["SetPlacement"]


class SetPlacement:
    """Line ``way sets + key mod sets``; a set evicts its least recently used key.

    With one way this is direct placement. Lines are filled in the order of their ways.

    Parameters
    ----------
    sets, ways
        Sets, and lines of a set: powers of two.
    """

    def __init__(self, *, sets: int, ways: int):
        for name, value in (("Sets", sets), ("Ways", ways)):
            if value < 1 or value & (value - 1):
                raise InputError(f"cache: {name} must be a power of two, not {value!r}")
        self._sets, self._ways = sets, ways
        self.clear()

    def clear(self) -> None:
        """Empty all lines."""
        # Per set: ways by key, least recently used first.
        self._used = [{} for _ in range(self._sets)]

    def access(self, keys) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See `golden.engine.memsys.bus.cache.Cache.access`."""
        keys = np.asarray(keys, dtype=np.int64).tolist()
        hit, line, victim = np.zeros(len(keys), dtype=bool), np.empty(len(keys), np.int64), np.full(len(keys), -1)
        for number, key in enumerate(keys):
            index = key % self._sets
            used = self._used[index]
            way = used.pop(key, None)
            hit[number] = way is not None
            if way is None:
                way = len(used)
                if way == self._ways:
                    victim[number] = oldest = next(iter(used))
                    way = used.pop(oldest)
            used[key] = way
            line[number] = way * self._sets + index
        return hit, line, victim
