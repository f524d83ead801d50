"""Section trace: the work of a section on one cluster, and its cycles."""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.machines.engine.cluster_cast import (
    add_part,
    add_stage,
    begin_cast,
    end_cast,
    free,
    next_part,
    next_stage,
)
from radiosity.machines.engine.cluster_timing import ClusterTiming

__all__ = ["CastTimes", "SectionTrace", "run_stages"]


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


def run_stages(source, timing: ClusterTiming, *, slots: int, run_ahead: int, ahead: int = 0) -> CastTimes:
    """Cast the stages of a source, one after the other.

    Parameters
    ----------
    source
        The stages: ``patches``, ``barriers`` and ``listing`` of all of them, ``searches``, ``items`` and ``part`` of
        one, which is explored part by part when its grid rays are requested.
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
