"""I-structure memory: each location is written once per version; a read before the write is deferred.

Source: Shen 1993, section 5.2.4.1.
"""

__all__ = ["IStructure"]


class IStructure:
    """The memory, access by access.

    Parameters
    ----------
    count
        Locations.
    deferred
        Capacity of the deferred reads.

    Members
    -------
    waiting
        Tags of the deferred reads, by location, oldest first.
    """

    def __init__(self, count: int, *, deferred: int):
        self._data: list[int | None] = [None] * count
        self._capacity = deferred
        self.waiting: dict[int, list[int]] = {}

    @property
    def level(self) -> int:
        """Number of deferred reads."""
        return sum(map(len, self.waiting.values()))

    def start(self) -> bool:
        """Begin a version with all locations empty; refused while reads are deferred.

        Returns
        -------
        bool
            Whether it has begun.
        """
        if self.waiting:
            return False
        self._data = [None] * len(self._data)
        return True

    def read(self, address: int, tag: int) -> tuple[bool, list[int]]:
        """Read a location: the read is answered, or deferred if there is capacity.

        Returns
        -------
        tuple
            Whether the read is accepted, and the tags that are answered now.
        """
        if self._data[address] is not None:
            return True, [tag]
        if self.level == self._capacity:
            return False, []
        self.waiting.setdefault(address, []).append(tag)
        return True, []

    def write(self, address: int, data: int) -> tuple[bool, list[int]]:
        """Write a location if it is empty, and answer the reads deferred for it.

        Returns
        -------
        tuple
            Whether the write is accepted, and the tags that are answered now, in the order of the reads.
        """
        if self._data[address] is not None:
            return False, []
        self._data[address] = data
        return True, self.waiting.pop(address, [])

    def value(self, address: int) -> int | None:
        """Data of a location in this version, or None."""
        return self._data[address]
