import numpy as np

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.stimulus import stimulus
from golden.engine.stimulus.icu.edge_planes import plane_arrays
from hw.icu.edge_planes import EdgePlanes
from tb.icu.vectors import rows, slot_of, winding_of
from tb.lib.bench import Bench, Vectors


class TestEdgePlanes(Bench):
    """Random patches, and quads whose last two vertices differ in one component alone: they are no triangles."""

    component, interval = EdgePlanes, 4

    def vectors(self, config):
        directions = stimulus("icu.edge_planes", count=200, seed=3, config=config).arrays["direction"].copy()
        for axis in range(3):
            quads, others = directions[axis:60:3], [other for other in range(3) if other != axis]
            quads[:, 3, others] = quads[:, 2, others]
        planes = edge_planes(directions, config.numbers)
        assert 10 < planes.split[:60].sum() < 50
        given = plane_arrays(planes)
        signs = rows(np.sign(given["planes"][:, :5]))
        return Vectors(
            inputs={"i": [{**slot_of(k), "directions": vertices} for k, vertices in enumerate(rows(directions))]},
            expected={"o_planes": [{**slot_of(k), "part": planes} for k, planes in enumerate(rows(given["planes"]))],
                      "o": [{**slot_of(k), "winding": winding_of(given, k), "signs": signs[k]} for k in range(200)]})
