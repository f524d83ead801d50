"""I-structure memory: locations that are written once per version, and reads that wait for it.

Source: Shen 1993, section 5.2.4.1.
"""

import numpy as np

__all__ = ["IStructure", "answers"]


def answers(reads: np.ndarray, writes: np.ndarray, data: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the accesses of one version come to, in whatever order reads and writes meet.

    Parameters
    ----------
    reads
        Their addresses.
    writes, data
        Addresses and data of the writes, in their order: of several to one location the first one counts.

    Returns
    -------
    tuple
        Per read whether its location is written at all, and the data (0 where it is not); per write whether it is
        refused.
    """
    places, first = np.unique(writes, return_index=True)
    refused = np.ones(len(writes), dtype=bool)
    refused[first] = False
    if not len(places):
        return np.zeros(len(reads), dtype=bool), np.zeros(len(reads), dtype=np.int64), refused
    found = np.minimum(np.searchsorted(places, reads), len(places) - 1)
    answered = places[found] == reads
    return answered, np.where(answered, np.asarray(data)[first[found]], 0), refused


class IStructure:
    """The memory access by access.

    Parameters
    ----------
    count
        Locations.
    deferred
        Reads that can wait.

    Members
    -------
    waiting
        Tags of the reads that wait, by location, oldest first.
    """

    def __init__(self, count: int, *, deferred: int):
        self._data: list[int | None] = [None] * count
        self._room = deferred
        self.waiting: dict[int, list[int]] = {}

    @property
    def level(self) -> int:
        """Reads that wait."""
        return sum(map(len, self.waiting.values()))

    def start(self) -> bool:
        """Begin a version, in which all locations are empty. Not while reads wait.

        Returns
        -------
        Whether it has begun.
        """
        if self.waiting:
            return False
        self._data = [None] * len(self._data)
        return True

    def read(self, address: int, tag: int) -> tuple[bool, list[int]]:
        """Ask for a location: the read is answered, or waits if there is room.

        Returns
        -------
        tuple
            Whether the read is taken, and the tags that are answered now.
        """
        if self._data[address] is not None:
            return True, [tag]
        if self.level == self._room:
            return False, []
        self.waiting.setdefault(address, []).append(tag)
        return True, []

    def write(self, address: int, data: int) -> tuple[bool, list[int]]:
        """Write a location, if it is empty, and answer the reads that wait for it.

        Returns
        -------
        tuple
            Whether the write is taken, or else refused; and the tags that are answered now, in the order of the reads.
        """
        if self._data[address] is not None:
            return False, []
        self._data[address] = data
        return True, self.waiting.pop(address, [])

    def value(self, address: int) -> int | None:
        """What has been written to a location in this version."""
        return self._data[address]
