"""Filter: each cell, and each patch, passes once per frustum and cluster."""

import numpy as np

__all__ = ["Filter"]


class Filter:
    """One tag per number; it equals the current generation if the number has passed.

    Parameters
    ----------
    count
        Numbers are from 0 to ``count`` - 1.
    tag_bits
        Bits of a tag. The tags are cleared only after 2^tag_bits - 1 generations.

    Members
    -------
    seen, passed
        Numbers looked up, and numbers that passed, in this generation.
    """

    def __init__(self, count: int, *, tag_bits: int = 8):
        self._tag = np.zeros(count, dtype=np.int64)
        self._generations = 1 << tag_bits
        self._generation = 0
        self.clear()

    def clear(self) -> None:
        """Begin a new generation: every number may pass again."""
        self._generation += 1
        if self._generation == self._generations:
            self._tag[:] = 0
            self._generation = 1
        self.seen = self.passed = 0

    def first(self, numbers: np.ndarray) -> np.ndarray:
        """The numbers that have not passed before, each once, in the order of their first occurrence."""
        self.seen += len(numbers)
        numbers = numbers[self._tag[numbers] != self._generation]
        # The last of several writes to one tag stays: in reverse order that is the first occurrence. A negative tag is
        # no generation.
        order = np.arange(len(numbers))
        self._tag[numbers[::-1]] = ~order[::-1]
        numbers = numbers[self._tag[numbers] == ~order]
        self._tag[numbers] = self._generation
        self.passed += len(numbers)
        return numbers
