"""A memory image: its regions as arrays, and its bytes."""

from dataclasses import dataclass

import numpy as np

from golden.cast.fixed_hits import FixedHits
from golden.config import Numbers
from golden.ctu.sector import Sector
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.memory_map.beats import BEATS, unpack_beats
from golden.memory_map.check import check_image
from golden.memory_map.layout import ALIGNMENT, ENTRY, HEADER, MAGIC, REGIONS, VERSION, region_offsets

__all__ = ["MemoryImage", "from_bytes"]


@dataclass(frozen=True, eq=False)
class MemoryImage:
    """A memory image.

    Parameters
    ----------
    regions
        One array of records per region, by name, in the order of `REGIONS`.
    """

    regions: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.regions[name]

    @property
    def offsets(self) -> dict[str, int]:
        """First byte of each region in `to_bytes`."""
        return self._layout()[0]

    @property
    def size(self) -> int:
        """Bytes of the image."""
        return self._layout()[1]

    def _layout(self):
        return region_offsets({name: len(records) for name, records in self.regions.items()})

    def to_bytes(self) -> bytes:
        """The image in bytes: header, region table, regions; the same regions give the same bytes."""
        offsets, size = self._layout()
        entries = np.array([(offsets[region.name], len(self[region.name])) for region in REGIONS], dtype=ENTRY.dtype)
        header = np.array([(MAGIC, VERSION, size)], dtype=HEADER.dtype)
        data = bytearray(size)
        for offset, part in ((0, header), (HEADER.dtype.itemsize, entries),
                             *((offsets[region.name], self[region.name]) for region in REGIONS)):
            data[offset:offset + part.nbytes] = part.tobytes()
        return bytes(data)

    def vertices(self) -> np.ndarray:
        """Vertices of all patches: N x 4 x 3 int64, G coordinates."""
        return unpack_beats(self["patches"]["vertex"], self["patches"]["top"][:, 1:BEATS])

    def sections(self) -> tuple[Sector, ...]:
        """Section and sector of each cluster."""
        names = "first_column", "end_column", "first_row", "end_row"
        return tuple(Sector(*(int(cluster[name]) for name in names)) for cluster in self["clusters"])

    def residents(self, cluster: int) -> np.ndarray:
        """Patch ids of a cluster's resident set, by local address."""
        return self._listed("residents", cluster, "first_resident")["patch"]

    def subshells(self, cluster: int) -> np.ndarray:
        """S x 2 int64: patch and shell of each listed subshell of a cluster."""
        listed = self._listed("subshells", cluster, "first_subshell")
        return np.stack([listed["patch"], listed["shell"]], axis=1).astype(np.int64)

    def _listed(self, region, cluster, first):
        """The records of ``region`` that belong to a cluster."""
        record = self["clusters"][cluster]
        return self[region][int(record[first]):int(record[first]) + int(record[region])]

    def frustum(self, numbers: Numbers) -> FrustumRecord:
        """The frustum record, its numbers in the formats ``numbers``."""
        (one,) = self["frustum"]
        used = 1 if one["is_screen"] else 2
        wide = np.int64
        return FrustumRecord(
            is_screen=bool(one["is_screen"]), numbers=numbers, origin=one["origin"].astype(wide),
            matrix=one["matrix"].reshape(3, 3).astype(wide), to_global=one["to_global"].reshape(3, 3).astype(wide),
            z_scale=int(one["z_scale"]), half_angles=tuple(float(angle) for angle in one["half_angles"]),
            columns=int(one["columns"]), rows=int(one["rows"]), column_bits=int(one["column_bits"]),
            row_bits=int(one["row_bits"]), column_table=self["columns"]["table"][:, :used].astype(wide),
            row_table=self["rows"]["table"][:, :used].astype(wide), source=int(one["source"]))

    def hits(self) -> FixedHits:
        """The hits that the machine, or `with_results`, has written."""
        return FixedHits(**{name: self["hits"][name].astype(np.int64) for name in ("inverse", "patch", "u", "v")})

    def with_results(self, hits: FixedHits) -> "MemoryImage":
        """The image after the machine has cast: with ``hits`` and the sums of their weights."""
        written, sums = self["hits"].copy(), self["sums"].copy()
        for name in "inverse", "patch", "u", "v":
            written[name] = getattr(hits, name)
        weight = np.repeat(self["rows"]["weight"], len(self["columns"]))
        sums["sum"] = 0
        np.add.at(sums["sum"], np.where(hits.patch >= 0, hits.patch, len(sums) - 1), weight)
        return MemoryImage({**self.regions, "hits": written, "sums": sums})


def from_bytes(data: bytes) -> MemoryImage:
    """The image in ``data``, checked (`golden.memory_map.check`).

    Raises
    ------
    InputError
        ``data`` is no image, of another version or incomplete; a region lies outside it; or a table breaks a rule.
    """
    if len(data) < HEADER.dtype.itemsize + len(REGIONS) * ENTRY.dtype.itemsize:
        raise InputError(f"memory image: {len(data)} bytes are too few for a header")
    (header,) = np.frombuffer(data, dtype=HEADER.dtype, count=1)
    for name, expected in ("magic", MAGIC), ("version", VERSION), ("size", len(data)):
        if header[name] != expected:
            raise InputError(f"memory image: {name.capitalize()} must be {expected}, not {header[name]}")
    entries = np.frombuffer(data, dtype=ENTRY.dtype, count=len(REGIONS), offset=HEADER.dtype.itemsize)
    regions = {}
    for entry, region in zip(entries, REGIONS, strict=True):
        offset, count = int(entry["offset"]), int(entry["count"])
        if offset % ALIGNMENT or offset + count * region.dtype.itemsize > len(data):
            raise InputError(f"memory image: region {region.name}, {count} records at {offset}, lies outside the image")
        regions[region.name] = np.frombuffer(data, dtype=region.dtype, count=count, offset=offset)
    image = MemoryImage(regions)
    check_image(image)
    return image
