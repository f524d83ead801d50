"""The cycles and counters of a frustum's casts as one table."""

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from radiosity.flow.simulator.job_result import JobResult

__all__ = ["cast_report"]


def cast_report(record: FrustumRecord, done: list[JobResult], config: Config) -> dict:
    """Cycles, bounds, rates and counters of the last of several jobs that cast a frustum; the first one's cycles.

    Efficiency and bounds are of the cycles of the cast, without loads and results.
    """
    last, first = done[-1], done[0]
    ((frustum,),) = last.frusta
    patch = frustum.hits.patch if isinstance(frustum.hits, FixedHits) else frustum.hits
    bound, cast = last.bound(config), max(1, last.cycles.cast)
    tested, patches = last.total("intersection_tested"), last.total("memory_found")
    return {
        "rays": len(record), "hits": int((np.asarray(patch) >= 0).sum()), "cycles": last.cycles.total,
        "first_cycles": first.cycles.total, "load_cycles": first.cycles.load, "cast_cycles": last.cycles.cast,
        "result_cycles": last.cycles.results, "sections": len(frustum.records),
        "bound": bound, "of_bound": max(bound.values()) / cast,
        "efficiency": tested / cast / len(last.counters), "tests_per_ray": tested / len(record),
        "edrc": tested / max(1, patches), "links": last.links(config),
        "sources": {name: last.total(f"memory_{name}") for name in ("own", "kept", "remote", "hits", "misses")},
        "deferred": last.total("memory_deferred"), "shared": last.shared,
        "each": [{"efficiency": one["intersection_tested"] / cast,
                  "edrc": one["intersection_tested"] / max(1, one["memory_found"]), **one}
                 for one in last.counters]}
