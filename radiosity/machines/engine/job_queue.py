"""Job queue: the events of a job, from the first section that is dispatched to the last result.

A dispatcher sends section after section, each to the cluster that has waited longest. A cluster casts one section, has
the next one in its slot, and writes the results of the one before. All clusters share the port of writes.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import EventHeap, event_heap, next_time, pop, push
from radiosity.machines.engine.job_timing import JobTiming

__all__ = ["JobSections", "JobTimes", "run_queue"]

_REQUEST, _SENT, _SLOT, _END, _MADE, _PORT, _RAYS_DONE, _DONE, _FREE = range(9)
# Of a cluster: the section that is being sent to it, the one in its slot, the one that is cast, the one whose cast has
# ended before the results of another one, the one whose results are written, and when the next cast may begin.
_COMES, _WAITS, _CAST, _ENDED, _WRITTEN, _IDLE = range(6)
# Of the section that is written: beats that are in no request yet, whether a request is being made, requests that wait
# for the port and where the first of them is, those that memory has not got, and whether sums are written.
_LEFT, _MAKING, _READY, _HEAD, _OPEN, _IS_SUMS = range(6, 12)
# Of the job: the next section, the clusters that wait for one, and which of them is first; whether a section is being
# sent, whether the port is busy, and the cluster that has had it last.
_NEXT, _WAITING, _FIRST, _SENDING, _PORT_BUSY, _GRANTED = range(6)
_NONE = -1
# Events of a cluster that can wait at the same time.
_EACH = 8
_TIMES = ("dispatch", "slot", "restart", "read_out", "sums", "answer", "report", "beats")
_DISPATCH, _TO_BEGIN, _RESTART, _READ_OUT, _TO_SUMS, _ANSWER, _REPORT, _BEATS = range(8)
# Rows of what is known of sections, and of their times.
_NEAR, _UNTIL_FREE, _CYCLES, _RAYS, _HITS, _SUMS = range(6)
_CLUSTER, _BEGINS, _ENDS, _DONES = range(4)


@dataclass(frozen=True, kw_only=True, eq=False)
class JobSections:
    """The sections of a job in the order of the queue.

    Parameters
    ----------
    near
        S int64: words of near cells, and of a shadow frustum's rays, behind the descriptor.
    free
        S int64: cycles from the begin of a cast until its cluster can use the next section.
    cycles
        S int64: cycles of the cast.
    rays
        S int64: rays that are read out, one in each cycle; of a shadow frustum those of its list.
    hits, sums
        S int64: beats of hits and of sums.
    """

    near: np.ndarray
    free: np.ndarray
    cycles: np.ndarray
    rays: np.ndarray
    hits: np.ndarray
    sums: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class JobTimes:
    """Cycles of the events of a job, from the begin of its load.

    Parameters
    ----------
    load
        The end of the load.
    cluster
        S int64: the cluster that casts each section.
    begins, ends, done
        S int64: begin and end of each cast, and when its results have been written.
    """

    load: int
    cluster: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    done: np.ndarray

    @property
    def cycles(self) -> int:
        """The end of the job."""
        return int(self.done.max(initial=self.load))


class _Queue(NamedTuple):
    """A job in flat arrays: events, work and times of sections, clusters, the beats of their requests that wait for the
    port, the ring of waiting clusters, the job.
    """

    heap: EventHeap
    work: np.ndarray
    times: np.ndarray
    clusters: np.ndarray
    requests: np.ndarray
    waiting: np.ndarray
    job: np.ndarray
    limits: np.ndarray


def run_queue(sections: JobSections, timing: JobTiming, *, clusters: int, load: int) -> JobTimes:
    """The times of a job.

    Parameters
    ----------
    sections
        Its sections.
    timing
        Latencies and capacities.
    clusters
        Clusters of the machine.
    load
        Cycles of the load before the first section.
    """
    work = np.stack([np.asarray(getattr(sections, field.name), dtype=np.int64) for field in fields(sections)])
    state = np.full((clusters, 12), _NONE, dtype=np.int64)
    state[:, _IDLE:] = 0
    job = np.zeros(6, dtype=np.int64)
    job[_GRANTED] = clusters - 1
    queue = _Queue(
        heap=event_heap(_EACH * clusters + 2), work=work, times=np.zeros((4, work.shape[1]), dtype=np.int64),
        clusters=state, requests=np.zeros((clusters, timing.buffers), dtype=np.int64),
        waiting=np.zeros(clusters, dtype=np.int64), job=job,
        limits=np.array([getattr(timing, name) for name in _TIMES], dtype=np.int64))
    for cluster in range(clusters):
        push(queue.heap, load + timing.first, _REQUEST, cluster)
    _run(queue)
    return JobTimes(load=load, cluster=queue.times[_CLUSTER], begins=queue.times[_BEGINS], ends=queue.times[_ENDS],
                    done=queue.times[_DONES])


@compiled
def _run(queue):
    """All events."""
    heap, job, limits, times = queue.heap, queue.job, queue.limits, queue.times
    while next_time(heap) != _NONE:
        time, kind, cluster = pop(heap)
        state = queue.clusters[cluster]
        if kind == _REQUEST:
            queue.waiting[(job[_FIRST] + job[_WAITING]) % len(queue.waiting)] = cluster
            job[_WAITING] += 1
            _dispatch(queue, time)
        elif kind == _SENT:
            job[_SENDING] = 0
            push(heap, time + limits[_TO_BEGIN], _SLOT, cluster)
            _dispatch(queue, time)
        elif kind == _SLOT:
            state[_WAITS], state[_COMES] = state[_COMES], _NONE
            _begin(queue, cluster, time)
        elif kind == _END:
            times[_ENDS, state[_CAST]] = time
            state[_ENDED] = state[_CAST]
            _read_out(queue, cluster, time)
        elif kind == _RAYS_DONE:
            state[_IS_SUMS], state[_LEFT] = 1, queue.work[_SUMS, state[_WRITTEN]]
            _make(queue, cluster, time)
            _end(queue, cluster, time)
        elif kind == _MADE:
            state[_MAKING] = 0
            state[_READY] += 1
            if state[_LEFT] == 0 and not state[_IS_SUMS]:
                push(heap, time + limits[_TO_SUMS], _RAYS_DONE, cluster)
            _make(queue, cluster, time)
            _grant(queue, time)
        elif kind == _PORT:
            job[_PORT_BUSY] = 0
            state[_OPEN] -= 1
            _end(queue, cluster, time)
            _grant(queue, time)
        elif kind == _DONE:
            times[_DONES, state[_WRITTEN]] = time
            push(heap, time + limits[_REPORT], _FREE, cluster)
        else:
            state[_WRITTEN] = _NONE
            _read_out(queue, cluster, time)


@compiled
def _dispatch(queue, time):
    """The next section goes to the cluster that has waited longest."""
    job = queue.job
    if job[_SENDING] or job[_WAITING] == 0 or job[_NEXT] == queue.work.shape[1]:
        return
    cluster, section = queue.waiting[job[_FIRST]], job[_NEXT]
    job[_FIRST] = (job[_FIRST] + 1) % len(queue.waiting)
    job[_WAITING] -= 1
    job[_NEXT] += 1
    job[_SENDING] = 1
    queue.clusters[cluster, _COMES] = section
    queue.times[_CLUSTER, section] = cluster
    push(queue.heap, time + queue.limits[_DISPATCH] + queue.work[_NEAR, section], _SENT, cluster)


@compiled
def _begin(queue, cluster, time):
    """The section in the slot is cast, if the cluster is idle."""
    state = queue.clusters[cluster]
    section = state[_WAITS]
    if section == _NONE or state[_CAST] != _NONE:
        return
    begin = max(time, state[_IDLE])
    state[_CAST], state[_WAITS] = section, _NONE
    queue.times[_BEGINS, section] = begin
    push(queue.heap, begin + queue.work[_UNTIL_FREE, section], _REQUEST, cluster)
    push(queue.heap, begin + queue.work[_CYCLES, section], _END, cluster)


@compiled
def _read_out(queue, cluster, time):
    """The results of the cast that has ended are read out when those before are written, and the next cast begins."""
    state, limits = queue.clusters[cluster], queue.limits
    if state[_ENDED] == _NONE or state[_WRITTEN] != _NONE:
        return
    section = state[_ENDED]
    state[_WRITTEN], state[_ENDED], state[_CAST] = section, _NONE, _NONE
    state[_IDLE] = time + limits[_RESTART]
    _begin(queue, cluster, time)
    state[_LEFT], state[_IS_SUMS] = queue.work[_HITS, section], 0
    if state[_LEFT]:
        _make(queue, cluster, time + limits[_READ_OUT])
    else:
        push(queue.heap, time + limits[_READ_OUT] + queue.work[_RAYS, section] + limits[_TO_SUMS], _RAYS_DONE, cluster)


@compiled
def _make(queue, cluster, time):
    """The next request is made: a beat in a cycle, of hits that are shorter than a beat several rays for each."""
    state, limits, work = queue.clusters[cluster], queue.limits, queue.work
    if state[_MAKING] or state[_LEFT] == 0 or state[_READY] == queue.requests.shape[1]:
        return
    beats = min(state[_LEFT], limits[_BEATS])
    queue.requests[cluster, (state[_HEAD] + state[_READY]) % queue.requests.shape[1]] = beats
    state[_LEFT] -= beats
    state[_MAKING] = 1
    state[_OPEN] += 1
    cycles = beats
    if not state[_IS_SUMS]:
        section = state[_WRITTEN]
        cycles = max(beats, beats * work[_RAYS, section] // work[_HITS, section])
    push(queue.heap, time + cycles, _MADE, cluster)


@compiled
def _grant(queue, time):
    """The port is granted to the clusters in turn, for a request each."""
    job, count = queue.job, len(queue.clusters)
    if job[_PORT_BUSY]:
        return
    for offset in range(1, count + 1):
        cluster = (job[_GRANTED] + offset) % count
        state = queue.clusters[cluster]
        if state[_READY]:
            job[_GRANTED], job[_PORT_BUSY] = cluster, 1
            push(queue.heap, time + queue.requests[cluster, state[_HEAD]], _PORT, cluster)
            state[_HEAD] = (state[_HEAD] + 1) % queue.requests.shape[1]
            state[_READY] -= 1
            _make(queue, cluster, time)
            return


@compiled
def _end(queue, cluster, time):
    """A section ends when memory has its last sum."""
    state = queue.clusters[cluster]
    if state[_IS_SUMS] and state[_LEFT] == 0 and state[_OPEN] == 0:
        push(queue.heap, time + queue.limits[_ANSWER], _DONE, cluster)
