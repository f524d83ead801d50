"""An image: its regions as arrays."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from golden.memory_map.beats import BEATS, unpack_beats
from golden.memory_map.image_layout import ImageLayout

__all__ = ["RegionImage"]


@dataclass(frozen=True, eq=False)
class RegionImage:
    """What images of all versions have in common.

    Parameters
    ----------
    regions
        One array of records per region, by name, in the order of the layout.

    Members
    -------
    layout
        The layout of the version.
    """

    regions: dict[str, np.ndarray]
    layout: ClassVar[ImageLayout]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.regions[name]

    @property
    def offsets(self) -> dict[str, int]:
        """First byte of each region in `to_bytes`."""
        return self._extent()[0]

    @property
    def size(self) -> int:
        """Bytes of the image."""
        return self._extent()[1]

    def _extent(self):
        return self.layout.offsets({name: len(records) for name, records in self.regions.items()})

    def to_bytes(self) -> bytes:
        """The image in bytes: header, region table, regions; the same regions give the same bytes."""
        return self.layout.to_bytes(self.regions)

    def vertices(self) -> np.ndarray:
        """Vertices of all patches: N x 4 x 3 int64, G coordinates."""
        return unpack_beats(self["patches"]["vertex"], self["patches"]["top"][:, 1:BEATS])

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
