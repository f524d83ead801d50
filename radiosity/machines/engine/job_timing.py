"""Job timing: latencies and capacities of what is between the casts of a job, as the components' docstrings state."""

from dataclasses import dataclass
from typing import ClassVar

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["JobTiming"]


@dataclass(frozen=True, kw_only=True)
class JobTiming(TimingNumbers):
    """Numbers of the engine that the golden model does not know, in cycles unless stated otherwise.

    `radiosity.machines.engine.job_latencies.job_timing` takes them from the components of a configuration.

    Parameters
    ----------
    first
        From the end of the load to the dispatch of the first section.
    dispatch
        Of a section, without its words of near cells.
    slot
        From the last word of a section to its begin, if its cluster is idle.
    restart
        From the end of a cast whose results are accepted to the begin of the next one.
    read_out
        From the acceptance of the results of a cast to its first hit.
    sums
        From the last hit to the first sum.
    answer
        From the last beat of a section at the port to the end of the section, as its completion record has it.
    report
        From there until the cluster can read out the next section.
    beats
        Beats of a request of writes, at most.
    buffers
        Requests of a cluster that wait for the port, at most.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is negative, or a capacity below 1.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("beats", "buffers")

    first: int
    dispatch: int
    slot: int
    restart: int
    read_out: int
    sums: int
    answer: int
    report: int
    beats: int
    buffers: int
