from golden.engine.stimulus import stimulus
from hw.icu.plane_factor import PlaneFactor
from tb.icu.vectors import factor_of, rows, slot_of
from tb.lib.bench import Bench, Vectors
from tb.lib.runner import SLOW_IN_ICARUS


class TestPlaneFactor(Bench):
    component, interval, simulators = PlaneFactor, 4, SLOW_IN_ICARUS

    def vectors(self, config):
        given = stimulus("icu.plane_factor", count=200, seed=3, config=config).arrays
        return Vectors(
            inputs={"i": [{**slot_of(k), "vertices": vertices} for k, vertices in enumerate(rows(given["vertices"]))]},
            expected={"o": [{**slot_of(k), "part": factor_of(given, k)} for k in range(200)]})


class TestShortNormals(TestPlaneFactor):
    """A normal has fewer bits than the leading ones of its factor."""

    changes, variants = {"numbers.vector_fraction": 10, "numbers.mantissa_bits": 24}, [{}]
