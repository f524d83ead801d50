"""Section trace: the work of a section on one cluster, and its cycles when it is replayed."""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.machines.engine.cluster_cast import (
    ClusterCast,
    StageItems,
    add_part,
    add_stage,
    begin_cast,
    clock,
    end_cast,
    free,
    next_part,
    next_stage,
)
from radiosity.machines.engine.cluster_timing import ClusterTiming

__all__ = ["CastTimes", "SectionTrace", "TraceSource", "replay", "run_stages"]


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionTrace:
    """What a cluster does for a section, stage by stage; the first one is the list of near cells.

    Parameters
    ----------
    cycles, searches
        S int64: cycles of each stage's requests; cycles of its searches of rows and columns.
    is_barrier
        S bool: the stage begins when all before it are over.
    first_cell
        S + 1 int64: the first cell of each stage.
    offset
        C int64: cycles from a stage's begin until survival has passed the grid ray that meets the cell.
    entries
        C + 1 int64: the first entry of each cell's list; a cell that is open already has none.
    is_new
        E bool: an entry is a patch that has not been found before.
    patch
        P int64: the patches in the order of discovery.
    tests
        P int64: cycles of the walk of each of them.
    listing
        Cycles in which the rays of a shadow frustum are listed, before anything else.
    """

    cycles: np.ndarray
    searches: np.ndarray
    is_barrier: np.ndarray
    first_cell: np.ndarray
    offset: np.ndarray
    entries: np.ndarray
    is_new: np.ndarray
    patch: np.ndarray
    tests: np.ndarray
    listing: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class CastTimes:
    """Cycles of the events of a cast, from its begin.

    Parameters
    ----------
    begins
        S int64: when each stage begins.
    ends
        P int64: when the last ray of each patch ends.
    free
        When the cluster could use the next section: all requests for grid rays had been accepted, and no cell and no
        patch was before the slots.
    cycles
        The end of the cast.
    """

    begins: np.ndarray
    ends: np.ndarray
    free: int
    cycles: int


class TraceSource:
    """The stages of a trace, see `run_stages`.

    Parameters
    ----------
    trace, timing
        The trace, and the latencies of the cluster.
    """

    def __init__(self, trace: SectionTrace, timing: ClusterTiming):
        self._trace, self._timing = trace, timing
        self._time = np.empty(len(trace.offset), dtype=np.int64)
        self._owner = np.full(len(trace.tests), -1)

    @property
    def patches(self) -> int:
        """Patches that are found."""
        return len(self._trace.tests)

    @property
    def barriers(self) -> np.ndarray:
        """Whether each stage waits until all before it are over; the list of near cells is the first one."""
        return self._trace.is_barrier

    @property
    def listing(self) -> int:
        """See `SectionTrace`."""
        return self._trace.listing

    def searches(self, stage: int) -> int:
        """Cycles of a stage's searches."""
        return int(self._trace.searches[stage])

    def items(self, stage: int, begin: int, cast: ClusterCast) -> tuple[StageItems, int]:
        """The items of all stages up to this one, which begins now; and the cycles of its requests."""
        trace, first, end = self._trace, *map(int, self._trace.first_cell[stage:stage + 2])
        latency = self._timing.memory + (self._timing.traversal if stage else 0)
        self._time[first:end] = clock(cast, begin) + latency + trace.offset[first:end]
        entries = trace.entries[:end + 1]
        return StageItems(self._time[:end], entries, trace.is_new[:entries[-1]], trace.tests, self._owner), int(
            trace.cycles[stage])

    def has_part(self) -> bool:
        """Whether the stage that has begun has requests that are not known yet: a trace knows all."""
        return False


def run_stages(source: TraceSource, timing: ClusterTiming, *, slots: int, run_ahead: int, ahead: int = 0) -> CastTimes:
    """Cast the stages of a source, one after the other.

    Parameters
    ----------
    source
        A trace's stages, or others that are explored part by part when their grid rays are requested.
    timing
        Latencies and capacities.
    slots, run_ahead
        ``icu.slots`` and ``ctu.run_ahead``.
    ahead
        See `begin_cast`. Default: no patch is of others.
    """
    timing = replace(timing, begin=timing.begin + source.listing)
    cast = begin_cast(timing, patches=source.patches, barriers=source.barriers, slots=slots, run_ahead=run_ahead,
                      found_ahead=ahead)
    begins, items = [], None
    for stage in range(len(source.barriers)):
        begins.append(next_stage(cast, items, timing.generator + source.searches(stage)) if stage else timing.begin)
        items, cycles = source.items(stage, begins[-1], cast)
        add_stage(cast, items, begins[-1], cycles, not stage)
        while source.has_part():
            begin = next_part(cast, items)
            items, cycles = source.part(begin, cast)
            add_part(cast, items, begin, cycles)
    end = end_cast(cast, items) + timing.over + timing.end
    return CastTimes(begins=np.array(begins), ends=cast.ends[:len(items.tests)].copy(), free=free(cast),
                     cycles=end)


def replay(trace: SectionTrace, timing: ClusterTiming, *, slots: int, run_ahead: int) -> CastTimes:
    """The cycles of a trace, see `run_stages`."""
    return run_stages(TraceSource(trace, timing), timing, slots=slots, run_ahead=run_ahead)
