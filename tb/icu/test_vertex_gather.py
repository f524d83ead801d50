from hw.icu.vertex_gather import VertexGather
from tb.icu.vectors import slot_of, vertex_key
from tb.lib.bench import Bench, Vectors


class TestVertexGather(Bench):
    component, arguments = VertexGather, {"shape": 8}
    per_result, variants = 4, [{}]

    def vectors(self, config):
        values = [(7 * k + k // 3) % 256 for k in range(200)]
        return Vectors(
            inputs={"i": [{**vertex_key(k), "item": value} for k, value in enumerate(values)]},
            expected={"o": [{**slot_of(k), "items": values[4 * k:4 * k + 4]} for k in range(50)]})
