"""Requests that patch stores serve in scenes larger than a cluster's memory: tables of ``radiosity bench caches``."""

from golden.cast.shelling import Shelling
from golden.config import Config
from golden.frustum import Hemisphere, hemisphere_record
from golden.memsys.patch_store import KEPT_OF, PatchStore
from golden.memsys.reference_strings import ReferenceStrings
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.ceiling_points import ceiling_points

__all__ = ["CLUSTERS", "FRUSTA", "request_strings", "store_table", "traffic_table"]

SCENES = ("room1627", "man", "mountain:6", "tetra:7")
SIZES, CELL = (128, 256, 512, 1024, 2048), 0.25
# Successive points of so many, of which one cluster has the first ones.
POINTS, FRUSTA = 256, 10
# What 16 clusters with memory for 1024 patches each may do with it: patches of the resident set and of the store.
CLUSTERS, SPLITS = 16, ((1024, 0), (512, 512), (768, 256))
# Cycles of a patch on the link to its cluster, and on the bus of all.
LINK, BUS = 5, 5


def request_strings(config: Config, hemisphere: Hemisphere) -> dict[str, list[list[int]]]:
    """Of each scene the patches of each frustum in the order in which they are found."""
    strings = {}
    for name in SCENES:
        scene = open_scene(name)
        points, down = ceiling_points(scene, POINTS)
        geometry = PatchGeometry.of(scene, config.numbers, points[:FRUSTA])
        records = [hemisphere_record(hemisphere, geometry.coordinates, point, down) for point in points[:FRUSTA]]
        requests = ReferenceStrings.of(Shelling(geometry, config, cell=CELL), records).patches
        strings[name] = [frustum[0].tolist() for frustum in requests]
    return strings


def store_table(strings: dict[str, list[list[int]]]) -> list[str]:
    """Lines: share of the requests that a store serves from the second frustum on, by its size; of a store that
    replaces a patch at every miss that meets another one, and of the hardware's.
    """
    lines = ["| scene | patches | one of | " + " | ".join(str(size) for size in SIZES) + " |",
             "|---" * (3 + len(SIZES)) + "|"]
    for name, (first, *others) in strings.items():
        for kept_of in (1, KEPT_OF):
            shares = []
            for size in SIZES:
                store = PatchStore(size, kept_of=kept_of)
                for patch in first:
                    store.request(patch)
                served = sum(store.request(patch) for frustum in others for patch in frustum)
                shares.append(f"{served / sum(map(len, others)):.3f}")
            lines.append(f"| {name} | {len({*first})} | {kept_of} | {' | '.join(shares)} |")
    return lines


def traffic_table(strings: dict[str, list[list[int]]]) -> list[str]:
    """Lines: patches of a frustum by source, from the second frustum on, and what they cost at least: cycles of a
    frustum on the link to its cluster, and cycles on the bus of as many frusta as there are clusters.
    """
    lines = ["| scene | own | store | from the store | from clusters | cycles of the link | from the bus "
             "| cycles of the bus |", "|---" * 8 + "|"]
    for name, (first, *others) in strings.items():
        for own, size in SPLITS:
            kept = remote = bus = 0
            for cluster in range(CLUSTERS):
                store = PatchStore(size) if size else None
                for patches in (first, *others):
                    for patch in patches:
                        is_held = patch < CLUSTERS * own
                        if is_held and patch % CLUSTERS == cluster:
                            continue
                        is_kept = store is not None and store.request(patch)
                        if patches is not first:
                            kept, remote, bus = kept + is_kept, remote + (is_held > is_kept), bus + (
                                not is_held and not is_kept)
            kept, remote, bus = (count / len(others) / CLUSTERS for count in (kept, remote, bus))
            lines.append(f"| {name} | {own} | {size} | {kept:.0f} | {remote:.0f} | {LINK * remote:.0f} | {bus:.0f} "
                         f"| {BUS * bus * CLUSTERS:.0f} |")
    return lines
