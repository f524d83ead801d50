"""Bus path: patches that no cluster holds, over the bus from the shared cache or from main memory.

Clusters request over one bus, a request in each cycle. The cache answers in order; fetches of misses overlap.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.engine.config import Memsys
from radiosity.machines.common.columns import columns
from radiosity.machines.common.timing_numbers import PositiveNumbers
from radiosity.machines.engine.cache_lines import CacheLines, access_line, cache_lines

__all__ = ["BusPath", "BusTiming", "bus_cycle", "bus_path", "bus_waits", "fetched", "request_on_bus"]

_NEVER = -1
# Numbers of the path: requests that wait, requests granted, fetches, the last answer, and the last fill.
_Number = columns("_Number", "WAITING GRANTED FETCHED ANSWERED FILLED")
_Time = columns("_Time", "REQUEST HIT FETCH NEXT_FETCH WORDS BEATS")
# Of a request that waits: the patch, and when it may be granted; of a cluster: requests granted, and all of them.
_Request = columns("_Request", "PATCH MADE")
_End = columns("_End", "GRANTED ALL")


@dataclass(frozen=True, kw_only=True)
class BusTiming(PositiveNumbers):
    """Numbers of the path to patches that no cluster holds, in cycles unless stated otherwise.

    `radiosity.machines.engine.job_latencies.bus_timing` takes them from the components of a configuration.

    Parameters
    ----------
    request
        From the cycle in which an own patch would be read to that in which the bus can grant the request for it.
    hit
        From a request that is granted to the cycle in which the patch can be read like an own one, of a hit.
    fetch
        The same of a miss, with main memory.
    next_fetch
        From the cycle in which a fetched patch can be read to the same of a fetch that has waited for its entry.
    words
        Of a patch that is fetched: one after the other.
    beats
        Of a patch on the bus, likewise.
    outstanding
        Patches that a cluster may have requested and not read, at most.
    fetches, requests
        Fetches, and requests, that the cache may have in flight.

    Raises
    ------
    TypeError, ValueError
        See `PositiveNumbers`.
    """

    request: int
    hit: int
    fetch: int
    next_fetch: int
    words: int
    beats: int
    outstanding: int
    fetches: int
    requests: int


class BusPath(NamedTuple):
    """The bus, the cache and main memory, which compiled functions advance.

    Parameters
    ----------
    latency
        Times of the path.
    numbers
        Its state.
    waiting
        Clusters x outstanding x 2 int64: patches that wait for the bus, and when each may be granted.
    ends
        Clusters x 2 int64: requests of each cluster that have been granted, and all of them.
    fills, answers
        Int64: when the patches of the last fetches, and of the last requests, could be read.
    cache
        Its lines.
    """

    latency: np.ndarray
    numbers: np.ndarray
    waiting: np.ndarray
    ends: np.ndarray
    fills: np.ndarray
    answers: np.ndarray
    cache: CacheLines


def bus_path(timing: BusTiming, memsys: Memsys, *, clusters: int, kept: np.ndarray) -> BusPath:
    """A path on which nothing is in flight.

    Parameters
    ----------
    timing
        Latencies and capacities.
    memsys
        The placement of the cache, and its lines.
    clusters
        Clusters that share it.
    kept
        P int64: patches that the cache has served before, in their order.
    """
    lines = cache_lines(memsys, lines=memsys.patch_lines)
    for patch in kept:
        access_line(lines, int(patch))
    def array(*shape):
        return np.zeros(shape, dtype=np.int64)

    return BusPath(np.array([getattr(timing, name.lower()) for name in _Time._fields], dtype=np.int64),
                   array(len(_Number)), array(clusters, timing.outstanding, len(_Request)), array(clusters, len(_End)),
                   array(timing.fetches), array(timing.requests), lines)


def fetched(path: BusPath) -> int:
    """Patches that have been read from main memory."""
    return int(path.numbers[_Number.FETCHED])


@compiled
def bus_waits(path: BusPath) -> bool:
    """Whether a request waits for the bus."""
    return path.numbers[_Number.WAITING] > 0


@compiled
def request_on_bus(path: BusPath, time: int, cluster: int, patch: int) -> None:
    """A cluster requests a patch, the scene's number of it."""
    entry = path.waiting[cluster, path.ends[cluster, _End.ALL] % path.waiting.shape[1]]
    entry[_Request.PATCH], entry[_Request.MADE] = patch, time + path.latency[_Time.REQUEST]
    path.ends[cluster, _End.ALL] += 1
    path.numbers[_Number.WAITING] += 1


@compiled
def bus_cycle(path: BusPath, time: int) -> tuple[int, int]:
    """A cycle of the bus: the cluster whose request is granted, -1 if none is, and when its patch can be read.

    The request that has waited longest is granted, of several that of the first cluster.
    """
    chosen, first = _NEVER, time + 1
    for cluster in range(len(path.ends)):
        begin, end = path.ends[cluster]
        if begin < end:
            made = path.waiting[cluster, begin % path.waiting.shape[1], _Request.MADE]
            if made < first:
                chosen, first = cluster, made
    if chosen == _NEVER:
        return _NEVER, 0
    patch = path.waiting[chosen, path.ends[chosen, _End.GRANTED] % path.waiting.shape[1], _Request.PATCH]
    path.ends[chosen, _End.GRANTED] += 1
    path.numbers[_Number.WAITING] -= 1
    return chosen, _answer(path, time, patch)


@compiled
def _answer(path, time, patch):
    """When a patch can be read whose request is granted now."""
    numbers, latency = path.numbers, path.latency
    # A request more than the cache has in flight is looked up when the oldest one has been answered.
    request = numbers[_Number.GRANTED] % len(path.answers)
    time = max(time, path.answers[request])
    if access_line(path.cache, patch):
        ready = time + latency[_Time.HIT]
    else:
        fetch = numbers[_Number.FETCHED] % len(path.fills)
        ready = max(time + latency[_Time.FETCH], numbers[_Number.FILLED] + latency[_Time.WORDS])
        if numbers[_Number.FETCHED] >= len(path.fills):
            ready = max(ready, path.fills[fetch] + latency[_Time.NEXT_FETCH])
        numbers[_Number.FILLED] = ready
        numbers[_Number.FETCHED] += 1
        path.fills[fetch] = ready
    ready = max(ready, numbers[_Number.ANSWERED] + latency[_Time.BEATS])
    numbers[_Number.ANSWERED] = ready
    path.answers[request] = ready
    numbers[_Number.GRANTED] += 1
    return ready
