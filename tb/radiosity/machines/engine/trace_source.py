"""Casts of traces: sections whose work is known before."""

import numpy as np

from radiosity.machines.engine.cluster_cast import ClusterCast, StageItems, clock
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.section_trace import CastTimes, SectionTrace, run_stages

__all__ = ["TraceSource", "replay"]


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


def replay(trace: SectionTrace, timing: ClusterTiming, *, slots: int, run_ahead: int) -> CastTimes:
    """The cycles of a trace, see `run_stages`."""
    return run_stages(TraceSource(trace, timing), timing, slots=slots, run_ahead=run_ahead)
