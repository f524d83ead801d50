import numpy as np

from golden.engine.stimulus import stimulus
from hw.icu.edge_planes import EdgePlanes
from tb.icu.vectors import rows, slot_of, winding_of
from tb.lib.bench import Bench, Vectors


class TestEdgePlanes(Bench):
    component, interval = EdgePlanes, 4

    def vectors(self, config):
        given = stimulus("icu.edge_planes", count=200, seed=3, config=config).arrays
        signs = rows(np.sign(given["planes"][:, :5]))
        return Vectors(
            inputs={"i": [{**slot_of(k), "directions": vertices}
                          for k, vertices in enumerate(rows(given["direction"]))]},
            expected={"o_planes": [{**slot_of(k), "part": planes} for k, planes in enumerate(rows(given["planes"]))],
                      "o": [{**slot_of(k), "winding": winding_of(given, k), "signs": signs[k]} for k in range(200)]})
