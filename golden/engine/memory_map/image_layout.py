"""The bytes of an image: where its regions are, and their records."""

from collections.abc import Mapping

import numpy as np

from golden.base.errors import InputError
from golden.engine.memory_map.layout import ALIGNMENT, ENTRY, HEADER, MAGIC, REGIONS, VERSION
from golden.engine.memory_map.records import make_records

__all__ = ["aligned", "image_bytes", "image_offsets", "image_regions", "region_records"]

_BY_NAME = {region.name: region for region in REGIONS}
# Bytes of the header and the table of regions.
_HEAD = HEADER.dtype.itemsize + len(REGIONS) * ENTRY.dtype.itemsize


def region_records(name: str, length: int, **fields) -> np.ndarray:
    """Records of a region with the fields given and 0 in all others; `make_records`."""
    return make_records(_BY_NAME[name], length, "memory image", fields)


def image_offsets(counts: Mapping[str, int]) -> tuple[dict[str, int], int]:
    """The first byte of each region, and the size of the image in bytes.

    Parameters
    ----------
    counts
        Records of each region, by name.
    """
    offsets, end = {}, _HEAD
    for region in REGIONS:
        offsets[region.name] = aligned(end)
        end = offsets[region.name] + counts[region.name] * region.dtype.itemsize
    return offsets, aligned(end)


def image_bytes(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Header, region table, regions; the same arrays give the same bytes."""
    offsets, size = image_offsets({name: len(records) for name, records in arrays.items()})
    entries = np.array([(offsets[region.name], len(arrays[region.name])) for region in REGIONS], dtype=ENTRY.dtype)
    header = np.array([(MAGIC, VERSION, size)], dtype=HEADER.dtype)
    data = bytearray(size)
    for offset, part in ((0, header), (HEADER.dtype.itemsize, entries),
                         *((offsets[region.name], arrays[region.name]) for region in REGIONS)):
        data[offset:offset + part.nbytes] = part.tobytes()
    return bytes(data)


def image_regions(data: bytes) -> dict[str, np.ndarray]:
    """The records of each region of the image in ``data``, by name.

    Raises
    ------
    InputError
        ``data`` is no image, of another version or incomplete, or a region lies outside it.
    """
    if len(data) < _HEAD:
        raise InputError(f"memory image: {len(data)} bytes are too few for a header")
    (header,) = np.frombuffer(data, dtype=HEADER.dtype, count=1)
    for name, expected in ("magic", MAGIC), ("version", VERSION), ("size", len(data)):
        if header[name] != expected:
            raise InputError(f"memory image: {name.capitalize()} must be {expected}, not {header[name]}")
    entries = np.frombuffer(data, dtype=ENTRY.dtype, count=len(REGIONS), offset=HEADER.dtype.itemsize)
    arrays = {}
    for entry, region in zip(entries, REGIONS, strict=True):
        offset, count = int(entry["offset"]), int(entry["count"])
        if offset % ALIGNMENT or offset + count * region.dtype.itemsize > len(data):
            raise InputError(f"memory image: region {region.name}, {count} records at {offset}, lies outside the "
                             "image")
        arrays[region.name] = np.frombuffer(data, dtype=region.dtype, count=count, offset=offset)
    return arrays


def aligned(size: int) -> int:
    """The next multiple of `ALIGNMENT`."""
    return -(-size // ALIGNMENT) * ALIGNMENT
