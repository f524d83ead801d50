"""A memory image: its regions as arrays, and its bytes."""

from dataclasses import dataclass

import numpy as np

from golden.engine.memory_map.beats import BEATS, unpack_beats
from golden.engine.memory_map.check import check_image
from golden.engine.memory_map.image_layout import image_bytes, image_offsets, image_regions

__all__ = ["MemoryImage", "from_bytes"]


@dataclass(frozen=True, eq=False)
class MemoryImage:
    """The image of a scene and a phase.

    Parameters
    ----------
    regions
        One array of records per region, by name, in the order of `golden.engine.memory_map.layout.REGIONS`.
    """

    regions: dict[str, np.ndarray]

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
        return image_offsets({name: len(records) for name, records in self.regions.items()})

    def to_bytes(self) -> bytes:
        """The image in bytes: header, region table, regions; the same regions give the same bytes."""
        return image_bytes(self.regions)

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

    @property
    def has_copies(self) -> bool:
        """Whether the tables of cluster 0 are those of every cluster: none has patches or lists of its own."""
        return not len(self["subshells"]) and bool((self["residence"]["cluster"] < 0).all())

    @property
    def last_shell(self) -> int:
        """The last shell that there are grid rays for."""
        return len(self["shells"]) + 1


def from_bytes(data: bytes) -> MemoryImage:
    """The image in ``data``, checked (`golden.engine.memory_map.check`).

    Raises
    ------
    InputError
        ``data`` is no image, of another version or incomplete; a region lies outside it; or a table breaks a rule.
    """
    image = MemoryImage(image_regions(data))
    check_image(image)
    return image
