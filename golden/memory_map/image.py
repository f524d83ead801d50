"""A memory image: its regions as arrays, and its bytes."""

from dataclasses import dataclass

import numpy as np

from golden.cast.fixed_hits import FixedHits
from golden.config import Numbers
from golden.ctu.sector import Sector
from golden.frustum import FrustumRecord
from golden.memory_map.check import check_image
from golden.memory_map.image_layout import IMAGE_LAYOUT
from golden.memory_map.region_image import RegionImage

__all__ = ["MemoryImage", "from_bytes"]


@dataclass(frozen=True, eq=False)
class MemoryImage(RegionImage):
    """The image of a scene, a phase and a frustum.

    Parameters
    ----------
    regions
        One array of records per region, by name, in the order of `REGIONS`.
    """

    layout = IMAGE_LAYOUT

    def sections(self) -> tuple[Sector, ...]:
        """Section and sector of each cluster."""
        names = "first_column", "end_column", "first_row", "end_row"
        return tuple(Sector(*(int(cluster[name]) for name in names)) for cluster in self["clusters"])

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
    image = MemoryImage(IMAGE_LAYOUT.from_bytes(data))
    check_image(image)
    return image
