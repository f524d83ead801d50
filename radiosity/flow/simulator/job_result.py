"""What a job on the simulated machine returns: results of each frustum, cycles, counters."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.completion import patch_sources
from golden.engine.jobs.descriptor import Kind
from golden.engine.jobs.job import Job, Read
from golden.engine.jobs.load_regions import region_bits
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.noc.packing import reply_flits, request_flits
from hw.cluster import COUNTERS, RECORDED
from hw.ctu.ctu_formats import GRID_GROUP

__all__ = ["KEPT", "OF_CACHES", "SHARED_COUNTERS", "SINCE_RESET", "FrustumResult", "JobCycles", "JobResult",
           "cluster_counters", "frustum_results", "loads_scene"]

# Registers that count for the whole machine, beside the counters of each cluster; those of caches begin with a load of
# the scene.
OF_CACHES = ("cell_hits", "cell_misses", "patch_hits", "patch_misses")
SHARED_COUNTERS = ("flits", "flit_stalls", *OF_CACHES)
# Counters of a cluster that the machine does not clear when a section begins.
SINCE_RESET = ("memory_answered", "memory_deferred", "memory_stalls")
# The counter that completion records have no field for: it follows from the others.
KEPT = "memory_kept"
# Cycle counters wrap.
_WORD = 1 << 32


@dataclass(frozen=True, kw_only=True, eq=False)
class FrustumResult:
    """The results of a frustum.

    Parameters
    ----------
    hits
        `FixedHits`; of the format of ids R int64, the patches alone; None of no format. Of a shadow frustum R bool,
        whether each ray is blocked.
    sums
        N int64 for N patches; None if they were not requested.
    records
        Completion records of its sections.
    """

    hits: FixedHits | np.ndarray | None
    sums: np.ndarray | None
    records: np.ndarray

    def total(self, name: str) -> int:
        """A field of the completion records, summed over the sections."""
        return int(self.records[name].sum())


@dataclass(frozen=True, kw_only=True)
class JobCycles:
    """The cycles of a job by activity.

    Parameters
    ----------
    total
        From the doorbell to the last result: the last write that memory has answered.
    load
        Of all loads.
    cast
        From the beginning of the first section's cast to the end of the last one's, with loads between them.
    results
        From there to the last result.
    """

    total: int
    load: int
    cast: int
    results: int

    @classmethod
    def of(cls, job: Job, records: np.ndarray, doorbell: int) -> "JobCycles":
        """The cycles of a job from its completion records and from the cycle of its doorbell."""
        loads = job.descriptors["kind"][records["tag"]] == Kind.LOAD
        begin, end, cycles = (records[name].astype(np.int64) for name in ("begin", "end", "cycles"))
        since, until = (begin - doorbell) % _WORD, (end - doorbell) % _WORD
        casts = ~loads
        over = (since + cycles)[casts].max(initial=0)
        total = int(until.max(initial=0))
        return cls(total=total, load=int((until - since)[loads].sum()), results=max(0, total - int(over)),
                   cast=int(over - since[casts].min(initial=over)))


@dataclass(frozen=True, kw_only=True, eq=False)
class JobResult:
    """The results of a job.

    Parameters
    ----------
    job
        The job.
    frusta
        Of each phase the results of its frusta, in their order in the request.
    records
        All completion records, in the order of completion.
    cycles
        The cycles of the job.
    counters
        Of each cluster, for the whole job: `hw.cluster.COUNTERS` if no cluster has cast more than one section, else
        those that completion records have, `KEPT`, and `SINCE_RESET`.
    shared
        `SHARED_COUNTERS` of the job; those of caches since its last load of a scene, if there is one.
    """

    job: Job
    frusta: tuple[tuple[FrustumResult, ...], ...]
    records: np.ndarray
    cycles: JobCycles
    counters: list[dict[str, int]]
    shared: dict[str, int]

    def total(self, name: str) -> int:
        """A counter, summed over all clusters."""
        return sum(one[name] for one in self.counters)

    def bound(self, config: Config) -> dict[str, int]:
        """Lower bounds of the cycles, by unit: what the unit of the busiest cluster needs at its full rate.

        Traversal takes the largest of four, as far as they are known: steps divided by the pipelines, cells met, grid
        rays sent, and grid rays requested divided by the size of a group. Intersection takes a cycle for each test, a
        patch four cycles.
        """
        pipelines = config.ctu.traversal_pipelines(config.noc.clusters)
        return {"traversal": max(max(
                    -(-one["traversal_steps"] // pipelines), one.get("traversal_cells", 0),
                    one.get("traversal_rays", 0), -(-one.get("traversal_requests", 0) // GRID_GROUP))
                    for one in self.counters),
                "intersection": max(one["intersection_tested"] for one in self.counters),
                "patches": max(4 * one["memory_found"] for one in self.counters)}

    def links(self, config: Config) -> float:
        """Mean number of links that a flit passes; 0 if none was sent."""
        least = {"source": 0, "destination": 0, "patch": 0}
        flits = len(request_flits(config, **least)) + len(reply_flits(
            config, **least, surface=0, vertices=[(0, 0, 0)] * 4))
        sent = flits * self.total("memory_remote")
        return max(0.0, self.shared["flits"] / sent - 1) if sent else 0.0


def frustum_results(job: Job, records: np.ndarray, read: Read) -> tuple[tuple[FrustumResult, ...], ...]:
    """Of each phase the results of its frusta.

    Parameters
    ----------
    job, records
        The job and its completion records.
    read
        Reads main memory.
    """
    by_tag = records[np.argsort(records["tag"])]
    words = dict(zip(by_tag["tag"].tolist(), by_tag["sums"].tolist(), strict=True))
    numbers: list[list[list[int]]] = [[[] for _ in phase.request.records] for phase in job.phases]
    for number, one in enumerate(job.sections):
        if one is not None:
            numbers[one.phase][one.frustum].append(number)

    def hits(number, frustum):
        request = job.phases[number].request
        if request.records[frustum].bundle == Bundle.SHADOW:
            return job.blocked(number, frustum, read, numbers=numbers[number][frustum])
        return None if request.hit_format == HitFormat.NONE else job.hits(number, frustum, read)

    return tuple(tuple(FrustumResult(
        hits=hits(number, frustum),
        sums=job.sums(number, frustum, read, words, numbers=sections) if phase.request.sums else None,
        records=by_tag[sections])
        for frustum, sections in enumerate(numbers[number])) for number, phase in enumerate(job.phases))


def cluster_counters(job: Job, records: np.ndarray, now: list[Mapping[str, int]],
                     before: list[Mapping[str, int]]) -> list[dict[str, int]]:
    """`JobResult.counters`.

    Parameters
    ----------
    job, records
        The job and its completion records.
    now, before
        `hw.cluster.COUNTERS` of each cluster after the job, and `SINCE_RESET` before it.
    """
    casts = records[job.descriptors["kind"][records["tag"]] == Kind.FRUSTUM]
    own = [casts[casts["cluster"] == cluster] for cluster in range(len(now))]
    names = tuple(COUNTERS) if all(len(one) <= 1 for one in own) else (
        "cycles", *RECORDED.values(), KEPT, *SINCE_RESET)
    summed = {"cycles": "cycles"} | {counter: name for name, counter in RECORDED.items()}
    found = []
    for sections, read, earlier in zip(own, now, before, strict=True):
        values = {name: (read[name] if len(sections) else 0) for name in names}
        values |= {counter: int(sections[name].sum()) for counter, name in summed.items()}
        values[KEPT] = int(patch_sources(sections)["kept"].sum())
        values |= {name: (read[name] - earlier[name]) % _WORD for name in SINCE_RESET}
        found.append(values)
    return found


def loads_scene(job: Job) -> bool:
    """Whether a job empties the caches."""
    loads = job.descriptors[job.descriptors["kind"] == Kind.LOAD]
    return bool((loads["regions"] & region_bits("cells")).any())
