from golden.engine.stimulus import stimulus
from hw.icu.vertex_direction import VertexDirection
from tb.icu.vectors import rows, vertex_key
from tb.lib.bench import Bench, Vectors


class TestVertexDirection(Bench):
    component = VertexDirection

    def vectors(self, config):
        given = stimulus("icu.vertex_direction", count=400, seed=3, config=config).arrays
        vertices, directions = rows(given["vertex"]), rows(given["direction"])
        return Vectors(
            inputs={"i": [{**vertex_key(k), "vertex": vertex} for k, vertex in enumerate(vertices)]},
            expected={"o": [{**vertex_key(k), "vertex": vertex, "direction": directions[k],
                             "exponent": int(given["exponent"][k])} for k, vertex in enumerate(vertices)]})
