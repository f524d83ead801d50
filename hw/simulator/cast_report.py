"""The cycles and counters of a frustum's casts as one table."""

from golden.config import Config
from golden.frustum import FrustumRecord
from hw.simulator.cast_result import CastResult

__all__ = ["cast_report"]


def cast_report(record: FrustumRecord, done: list[CastResult], config: Config) -> dict:
    """Cycles, bounds, rates and counters of the last of several casts of a frustum; the first one's cycles."""
    last, bound = done[-1], done[-1].bound(config)
    tested, patches = last.total("intersection_tested"), last.total("intersection_patches")
    return {
        "rays": len(record), "hits": int((last.image.hits().patch >= 0).sum()), "cycles": last.cycles,
        "first_cycles": done[0].cycles, "load_cycles": done[0].load_cycles, "result_cycles": last.result_cycles,
        "bound": bound, "of_bound": max(bound.values()) / last.cycles,
        "efficiency": tested / last.cycles / len(last.counters), "tests_per_ray": tested / len(record),
        "edrc": tested / max(1, patches), "links": last.links(config),
        "sources": {name: last.total(f"memory_{name}") for name in ("own", "remote", "hits", "misses")},
        "shared": last.shared,
        "each": [{"efficiency": one["intersection_tested"] / last.cycles,
                  "edrc": one["intersection_tested"] / max(1, one["intersection_patches"]), **one}
                 for one in last.counters]}
