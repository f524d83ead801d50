"""What a cluster's patch store serves of scenes larger than it: a table of ``radiosity bench caches``."""

from golden.cast.shelling import Shelling
from golden.config import Config
from golden.frustum import Hemisphere, hemisphere_record
from golden.memsys.patch_store import KEPT_OF, PatchStore
from golden.memsys.reference_strings import ReferenceStrings
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.ceiling_points import ceiling_points

__all__ = ["FRUSTA", "store_table"]

SCENES = ("room1627", "man", "mountain:6", "tetra:7")
SIZES, CELL = (128, 256, 512, 1024, 2048), 0.25
# Successive points of so many, of which one cluster has the first ones.
POINTS, FRUSTA = 256, 10


def store_table(config: Config, hemisphere: Hemisphere) -> list[str]:
    """Lines: share of the requests that a store serves from the second frustum on, by its size; of a store that
    replaces a patch at every miss that meets another one, and of the hardware's.
    """
    lines = ["| scene | patches | one of | " + " | ".join(str(size) for size in SIZES) + " |",
             "|---" * (3 + len(SIZES)) + "|"]
    for name in SCENES:
        scene = open_scene(name)
        points, down = ceiling_points(scene, POINTS)
        geometry = PatchGeometry.of(scene, config.numbers, points[:FRUSTA])
        records = [hemisphere_record(hemisphere, geometry.coordinates, point, down) for point in points[:FRUSTA]]
        strings = ReferenceStrings.of(Shelling(geometry, config, cell=CELL), records).patches
        first, *others = [frustum[0].tolist() for frustum in strings]
        for kept_of in (1, KEPT_OF):
            shares = []
            for size in SIZES:
                store = PatchStore(size, kept_of=kept_of)
                for patch in first:
                    store.request(patch)
                served = sum(store.request(patch) for frustum in others for patch in frustum)
                shares.append(f"{served / sum(map(len, others)):.3f}")
            lines.append(f"| {name} | {len(geometry)} | {kept_of} | {' | '.join(shares)} |")
    return lines
