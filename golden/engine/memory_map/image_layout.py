"""The layout of an image of one version: where its regions are, and its bytes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.memory_map.layout import ALIGNMENT, ENTRY, HEADER, MAGIC, REGIONS, VERSION, Region
from golden.engine.memory_map.records import make_records

__all__ = ["IMAGE_LAYOUT", "ImageLayout", "aligned"]

_OWNER = "memory image"


@dataclass(frozen=True)
class ImageLayout:
    """A header, a table of regions, and the regions in their order.

    Parameters
    ----------
    version
        What the header states.
    regions
        The regions.
    """

    version: int
    regions: tuple[Region, ...]

    def region(self, name: str) -> Region:
        """The region of a name."""
        return next(region for region in self.regions if region.name == name)

    def records(self, name: str, length: int, **fields) -> np.ndarray:
        """Records of a region with the fields given and 0 in all others; `make_records`."""
        return make_records(self.region(name), length, _OWNER, fields)

    def offsets(self, counts: Mapping[str, int]) -> tuple[dict[str, int], int]:
        """The first byte of each region, and the size of the image in bytes.

        Parameters
        ----------
        counts
            Records of each region, by name.
        """
        offsets, end = {}, self._head()
        for region in self.regions:
            offsets[region.name] = aligned(end)
            end = offsets[region.name] + counts[region.name] * region.dtype.itemsize
        return offsets, aligned(end)

    def to_bytes(self, arrays: Mapping[str, np.ndarray]) -> bytes:
        """Header, region table, regions; the same arrays give the same bytes."""
        offsets, size = self.offsets({name: len(records) for name, records in arrays.items()})
        entries = np.array([(offsets[region.name], len(arrays[region.name])) for region in self.regions],
                           dtype=ENTRY.dtype)
        header = np.array([(MAGIC, self.version, size)], dtype=HEADER.dtype)
        data = bytearray(size)
        for offset, part in ((0, header), (HEADER.dtype.itemsize, entries),
                             *((offsets[region.name], arrays[region.name]) for region in self.regions)):
            data[offset:offset + part.nbytes] = part.tobytes()
        return bytes(data)

    def from_bytes(self, data: bytes) -> dict[str, np.ndarray]:
        """The records of each region of the image in ``data``, by name.

        Raises
        ------
        InputError
            ``data`` is no image, of another version or incomplete, or a region lies outside it.
        """
        if len(data) < self._head():
            raise InputError(f"memory image: {len(data)} bytes are too few for a header")
        (header,) = np.frombuffer(data, dtype=HEADER.dtype, count=1)
        for name, expected in ("magic", MAGIC), ("version", self.version), ("size", len(data)):
            if header[name] != expected:
                raise InputError(f"memory image: {name.capitalize()} must be {expected}, not {header[name]}")
        entries = np.frombuffer(data, dtype=ENTRY.dtype, count=len(self.regions), offset=HEADER.dtype.itemsize)
        arrays = {}
        for entry, region in zip(entries, self.regions, strict=True):
            offset, count = int(entry["offset"]), int(entry["count"])
            if offset % ALIGNMENT or offset + count * region.dtype.itemsize > len(data):
                raise InputError(f"memory image: region {region.name}, {count} records at {offset}, lies outside the "
                                 "image")
            arrays[region.name] = np.frombuffer(data, dtype=region.dtype, count=count, offset=offset)
        return arrays

    def _head(self):
        return HEADER.dtype.itemsize + len(self.regions) * ENTRY.dtype.itemsize


def aligned(size: int) -> int:
    """The next multiple of `ALIGNMENT`."""
    return -(-size // ALIGNMENT) * ALIGNMENT


IMAGE_LAYOUT = ImageLayout(VERSION, REGIONS)
