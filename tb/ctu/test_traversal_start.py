"""Rays at the beginning of their shells: golden's cells, and parameters of the next borders."""

from functools import partial

import numpy as np

from golden.engine.ctu.cell_traversal import (
    BEGIN_BITS,
    INDEX_BITS,
    NEVER,
    PARAMETER_BITS,
    POSITION_FRACTION,
    RECIPROCAL_BITS,
    traversal_start,
)
from golden.engine.ctu.grid_rays import FRACTION
from hw.ctu.traversal_start import TraversalStart
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import DEPTHS
from tb.lib.coverage import Coverage
from tb.lib.runner import SLOW_IN_ICARUS

TAG, RAYS, MANY, ONE = 12, 240, 2_000, 1 << POSITION_FRACTION
SHAPE = np.array([18, 5, 700])


def drawn(seed, count):
    """Origin, directions and begins, of all sizes: low bits matter where numbers are small, high ones where not."""
    random = np.random.default_rng(seed)
    origin = random.integers(-4 * ONE, (SHAPE + 4) * ONE)
    direction = (random.choice((-1, 1), (count, 3)) * 2.0**random.uniform(0, FRACTION, (count, 3))).astype(np.int64)
    direction[random.random((count, 3)) < 0.1] = 0
    direction[::20] = np.sign(direction[::20]) << FRACTION
    begin = (2.0**random.uniform(0, BEGIN_BITS, count)).astype(np.int64)
    # Half of them end near the grid.
    begin[::2] = random.integers(0, 30 * ONE, len(begin[::2]))
    return origin, direction, begin


def walks(origin, direction, begin):
    """The ray's state as golden starts with it."""
    index, next_, between = traversal_start(origin, direction, begin[:, None])
    step = np.sign(direction)
    lost = ((index < 0) & (step <= 0)) | ((index >= SHAPE) & (step >= 0)) | (abs(2 * index + 1) > 1 << INDEX_BITS)
    inside = ((index >= 0) & (index < SHAPE)).all(axis=1)
    bits = 1 << np.arange(3)
    return [{"index": cell, "up": up, "down": down, "next": first, "between": more, "inside": is_in, "away": is_away}
            for cell, up, down, first, more, is_in, is_away in zip(
                index.tolist(), ((step > 0) @ bits).tolist(), ((step < 0) @ bits).tolist(), next_.tolist(),
                between.tolist(), inside.astype(int).tolist(), lost.any(axis=1).astype(int).tolist(), strict=True)]


def vectors(config, seed, count=RAYS):
    origin, direction, begin = drawn(seed, count)
    length = np.random.default_rng(seed).integers(NEVER, size=count).tolist()
    items, expected = [], []
    for tag, walk in enumerate(walks(origin, direction, begin)):
        items.append({"tag": tag, "direction": direction[tag].tolist(), "begin": int(begin[tag]),
                      "length": length[tag]})
        # The cell of a ray that is outside for good may need more bits than there are.
        expected.append({"tag": tag, "walk": {**walk, "index": None if walk["away"] else walk["index"],
                                              "inside": None if walk["away"] else walk["inside"],
                                              "length": length[tag]}})
    return Vectors(ports={"origin": origin.tolist(), "shape": SHAPE.tolist()}, inputs={"i": items},
                   expected={"o": expected})


class TestTraversalStart(Bench):
    component, arguments = TraversalStart, {"tag": TAG}
    simulators = SLOW_IN_ICARUS
    cases = {"few": Case(partial(vectors, seed=1), [{"icu.product_registers": depth} for depth in DEPTHS]),
             **{f"many, {seed}": Case(partial(vectors, seed=seed, count=MANY), []) for seed in (2, 3)}}

    def drawn(self, config, seed):
        return vectors(config, seed)


def test_the_rays_hold_every_case():
    cover = Coverage(["inside", "away", "outside, on the way", "never", "of one cell", "next of the largest bit",
                      "smallest direction", "a whole direction"])
    for seed in (1, 2, 3):
        origin, direction, begin = drawn(seed, RAYS if seed == 1 else MANY)
        for walk, way in zip(walks(origin, direction, begin), direction.tolist(), strict=True):
            cover.hit_all({
                "inside": walk["inside"], "away": walk["away"],
                "outside, on the way": not walk["inside"] and not walk["away"], "never": NEVER in walk["next"],
                "of one cell": ONE in walk["between"],
                "next of the largest bit": any(1 << PARAMETER_BITS - 1 <= one < NEVER for one in walk["next"]),
                "smallest direction": 1 in way or -1 in way, "a whole direction": 1 << FRACTION in way})
    cover.check()
    assert RECIPROCAL_BITS > FRACTION, "a whole direction has a reciprocal"
