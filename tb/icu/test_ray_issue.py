import numpy as np

from hw.icu.ray_issue import RayIssue
from tb.icu.vectors import assert_all_occur
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic, Expand, Rigid

COUNT, FIRST_COLUMN, FIRST_ROW = 120, 9, 70


def rays(masks, config):
    """The rays of masks, lowest first; a mask without rays is an item without a ray."""
    side = config.icu.tile_bits
    lanes, last_index = 1 << side, (1 << config.icu.side_bits) - 1
    for mask in masks:
        found = [lane for lane in range(lanes * lanes) if mask["mask"] >> lane & 1]
        for lane in found:
            column, row = (mask["tile_column"] << side) + lane % lanes, (mask["tile_row"] << side) + lane // lanes
            yield {"slot": mask["slot"], "ray": mask["tile"] << 2 * side | lane, "is_ray": 1,
                   "column": column + FIRST_COLUMN & last_index, "row": row + FIRST_ROW & last_index,
                   "last": mask["last"] & (lane == found[-1])}
        if not found:
            yield {"slot": mask["slot"], "is_ray": 0, "last": mask["last"], "ray": None, "column": None, "row": None}


def masks(config):
    """Masks of which many are empty, full, or of one ray; indices go round where the section's first ones are added."""
    draw, icu, lanes = np.random.default_rng(2), config.icu, 1 << 2 * config.icu.tile_bits
    tiles = 1 << icu.side_bits - icu.tile_bits
    numbers = [0, 1, 1 << lanes - 1, (1 << lanes) - 1]
    found = []
    for number in range(COUNT):
        mask = numbers[draw.integers(4)] if number % 2 else int.from_bytes(draw.bytes(8)) & (1 << lanes) - 1
        column, row = (int(value) if number % 3 else tiles - 1 for value in draw.integers(tiles, size=2))
        found.append({"slot": number % icu.slots, "tile": number, "tile_column": column, "tile_row": row,
                      "last": int(draw.integers(2)), "mask": mask})
    return found


class TestRayIssue(Bench):
    component, variants, splits = RayIssue, [{"icu.tile_bits": bits} for bits in (1, 2, 3)], False

    def vectors(self, config):
        given = masks(config)
        return Vectors(ports={"first_column": FIRST_COLUMN, "first_row": FIRST_ROW}, inputs={"i": given},
                       expected={"o": list(rays(given, config))})

    def stages(self, component, config):
        """A mask waits, one is being issued, and rays have two further cycles."""
        counts = (max(1, mask["mask"].bit_count()) for mask in self.now.inputs["i"])
        return [Rigid(1), Rigid(1), Expand(counts, holds=True), Elastic(component.latency - 2)]


def test_the_masks_hold_every_case():
    config = TestRayIssue().config()
    counts, last = (np.array(values) for values in zip(*(
        (mask["mask"].bit_count(), mask["last"]) for mask in masks(config)), strict=True))
    lanes = 1 << 2 * config.icu.tile_bits
    assert_all_occur({"no ray": counts == 0, "one ray": counts == 1, "all rays": counts == lanes,
                      "last with rays": (counts > 0) & (last > 0), "last without rays": (counts == 0) & (last > 0),
                      "not the last": last == 0, "a short mask after a long one": (counts[1:] < 2) & (counts[:-1] > 2)})
