from golden.engine.stimulus import stimulus
from hw.icu.uv_alignment import UvAlignment
from tb.icu.vectors import rows
from tb.lib.bench import Bench, Vectors


class TestUvAlignment(Bench):
    component, arguments = UvAlignment, {"tag": 9}

    def vectors(self, config):
        given = stimulus("icu.uv_subdivision", count=400, seed=3, config=config).arrays
        aligned = rows(given["aligned"] * given["held"][:, None])
        return Vectors(
            inputs={"i": [{"tag": k, "distances": rows(given["distances"][k]), "orientation": int(given["held"][k]),
                           "exponents": rows(given["exponents"][k])} for k in range(400)]},
            expected={"o": [{"tag": k, "distances": aligned[k]} for k in range(400)]})
