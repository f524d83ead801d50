"""Job queue: the events of a job, from the first section that is dispatched to the last result.

A dispatcher sends section after section, each to the cluster that has waited longest. A cluster casts one section, has
the next one in its slot, and writes the results of the one before. All clusters share the port of writes.
"""

from collections import namedtuple
from dataclasses import astuple, fields
from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import EventHeap, event_heap, next_time, pop, push
from radiosity.machines.engine.job_timing import JobTiming

__all__ = ["JobSections", "JobTimes", "run_queue"]

_REQUEST, _SENT, _SLOT, _END, _MADE, _PORT, _RAYS_DONE, _DONE, _FREE = range(9)
_Cluster = columns("_Cluster", "COMES WAITS CAST ENDED WRITTEN IDLE LEFT MAKING READY HEAD OPEN IS_SUMS")
"""The section that is being sent to a cluster, the one in its slot, the one that is cast, the one whose cast has ended
before the results of another one, the one whose results are written, and when the next cast may begin. Of the section
that is written: beats that are in no request yet, whether a request is being made, requests that wait for the port and
where the first of them is, those that memory has not got, and whether sums are written."""

_Job = columns("_Job", "NEXT WAITING FIRST SENDING PORT_BUSY GRANTED")
"""The next section, the clusters that wait for one, and which of them is first; whether a section is being sent,
whether the port is busy, and the cluster that has had it last."""

_NONE = -1
# Events of a cluster that can wait at the same time.
_EACH = 8
# A `JobTiming` in compiled code.
_Timing = namedtuple("_Timing", [field.name for field in fields(JobTiming)])


class JobSections(NamedTuple):
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


class JobTimes(NamedTuple):
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
    """A job in flat arrays: events, sections and their times, clusters, the beats of their requests that wait for the
    port, the ring of waiting clusters, the job, and its timing.
    """

    heap: EventHeap
    sections: JobSections
    times: JobTimes
    clusters: np.ndarray
    requests: np.ndarray
    waiting: np.ndarray
    job: np.ndarray
    timing: _Timing


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
    sections = JobSections(*(np.asarray(each, dtype=np.int64) for each in sections))
    state = np.full((clusters, len(_Cluster)), _NONE, dtype=np.int64)
    state[:, _Cluster.IDLE:] = 0
    job = np.zeros(len(_Job), dtype=np.int64)
    job[_Job.GRANTED] = clusters - 1
    times = JobTimes(load, *(np.zeros(len(sections.near), dtype=np.int64) for _ in range(4)))
    queue = _Queue(
        heap=event_heap(_EACH * clusters + 2), sections=sections, times=times, clusters=state,
        requests=np.zeros((clusters, timing.buffers), dtype=np.int64), waiting=np.zeros(clusters, dtype=np.int64),
        job=job, timing=_Timing(*astuple(timing)))
    for cluster in range(clusters):
        push(queue.heap, load + timing.first, _REQUEST, cluster)
    _run(queue)
    return times


@compiled
def _run(queue):
    """All events."""
    heap, job, timing, times = queue.heap, queue.job, queue.timing, queue.times
    while next_time(heap) != _NONE:
        time, kind, cluster = pop(heap)
        state = queue.clusters[cluster]
        if kind == _REQUEST:
            queue.waiting[(job[_Job.FIRST] + job[_Job.WAITING]) % len(queue.waiting)] = cluster
            job[_Job.WAITING] += 1
            _dispatch(queue, time)
        elif kind == _SENT:
            job[_Job.SENDING] = 0
            push(heap, time + timing.slot, _SLOT, cluster)
            _dispatch(queue, time)
        elif kind == _SLOT:
            state[_Cluster.WAITS], state[_Cluster.COMES] = state[_Cluster.COMES], _NONE
            _begin(queue, cluster, time)
        elif kind == _END:
            times.ends[state[_Cluster.CAST]] = time
            state[_Cluster.ENDED] = state[_Cluster.CAST]
            _read_out(queue, cluster, time)
        elif kind == _RAYS_DONE:
            state[_Cluster.IS_SUMS], state[_Cluster.LEFT] = 1, queue.sections.sums[state[_Cluster.WRITTEN]]
            _make(queue, cluster, time)
            _end(queue, cluster, time)
        elif kind == _MADE:
            state[_Cluster.MAKING] = 0
            state[_Cluster.READY] += 1
            if state[_Cluster.LEFT] == 0 and not state[_Cluster.IS_SUMS]:
                push(heap, time + timing.sums, _RAYS_DONE, cluster)
            _make(queue, cluster, time)
            _grant(queue, time)
        elif kind == _PORT:
            job[_Job.PORT_BUSY] = 0
            state[_Cluster.OPEN] -= 1
            _end(queue, cluster, time)
            _grant(queue, time)
        elif kind == _DONE:
            times.done[state[_Cluster.WRITTEN]] = time
            push(heap, time + timing.report, _FREE, cluster)
        else:
            state[_Cluster.WRITTEN] = _NONE
            _read_out(queue, cluster, time)


@compiled
def _dispatch(queue, time):
    """The next section goes to the cluster that has waited longest."""
    job = queue.job
    if job[_Job.SENDING] or job[_Job.WAITING] == 0 or job[_Job.NEXT] == len(queue.sections.near):
        return
    cluster, section = queue.waiting[job[_Job.FIRST]], job[_Job.NEXT]
    job[_Job.FIRST] = (job[_Job.FIRST] + 1) % len(queue.waiting)
    job[_Job.WAITING] -= 1
    job[_Job.NEXT] += 1
    job[_Job.SENDING] = 1
    queue.clusters[cluster, _Cluster.COMES] = section
    queue.times.cluster[section] = cluster
    push(queue.heap, time + queue.timing.dispatch + queue.sections.near[section], _SENT, cluster)


@compiled
def _begin(queue, cluster, time):
    """The section in the slot is cast, if the cluster is idle."""
    state = queue.clusters[cluster]
    section = state[_Cluster.WAITS]
    if section == _NONE or state[_Cluster.CAST] != _NONE:
        return
    begin = max(time, state[_Cluster.IDLE])
    state[_Cluster.CAST], state[_Cluster.WAITS] = section, _NONE
    queue.times.begins[section] = begin
    push(queue.heap, begin + queue.sections.free[section], _REQUEST, cluster)
    push(queue.heap, begin + queue.sections.cycles[section], _END, cluster)


@compiled
def _read_out(queue, cluster, time):
    """The results of the cast that has ended are read out when those before are written, and the next cast begins."""
    state, timing = queue.clusters[cluster], queue.timing
    if state[_Cluster.ENDED] == _NONE or state[_Cluster.WRITTEN] != _NONE:
        return
    section = state[_Cluster.ENDED]
    state[_Cluster.WRITTEN], state[_Cluster.ENDED], state[_Cluster.CAST] = section, _NONE, _NONE
    state[_Cluster.IDLE] = time + timing.restart
    _begin(queue, cluster, time)
    state[_Cluster.LEFT], state[_Cluster.IS_SUMS] = queue.sections.hits[section], 0
    if state[_Cluster.LEFT]:
        _make(queue, cluster, time + timing.read_out)
    else:
        push(queue.heap, time + timing.read_out + queue.sections.rays[section] + timing.sums, _RAYS_DONE, cluster)


@compiled
def _make(queue, cluster, time):
    """The next request is made: a beat in a cycle, of hits that are shorter than a beat several rays for each."""
    state, timing = queue.clusters[cluster], queue.timing
    if state[_Cluster.MAKING] or state[_Cluster.LEFT] == 0 or state[_Cluster.READY] == queue.requests.shape[1]:
        return
    beats = min(state[_Cluster.LEFT], timing.beats)
    queue.requests[cluster, (state[_Cluster.HEAD] + state[_Cluster.READY]) % queue.requests.shape[1]] = beats
    state[_Cluster.LEFT] -= beats
    state[_Cluster.MAKING] = 1
    state[_Cluster.OPEN] += 1
    cycles = beats
    if not state[_Cluster.IS_SUMS]:
        section = state[_Cluster.WRITTEN]
        cycles = max(beats, beats * queue.sections.rays[section] // queue.sections.hits[section])
    push(queue.heap, time + cycles, _MADE, cluster)


@compiled
def _grant(queue, time):
    """The port is granted to the clusters in turn, for a request each."""
    job, count = queue.job, len(queue.clusters)
    if job[_Job.PORT_BUSY]:
        return
    for offset in range(1, count + 1):
        cluster = (job[_Job.GRANTED] + offset) % count
        state = queue.clusters[cluster]
        if state[_Cluster.READY]:
            job[_Job.GRANTED], job[_Job.PORT_BUSY] = cluster, 1
            push(queue.heap, time + queue.requests[cluster, state[_Cluster.HEAD]], _PORT, cluster)
            state[_Cluster.HEAD] = (state[_Cluster.HEAD] + 1) % queue.requests.shape[1]
            state[_Cluster.READY] -= 1
            _make(queue, cluster, time)
            return


@compiled
def _end(queue, cluster, time):
    """A section ends when memory has its last sum."""
    state = queue.clusters[cluster]
    if state[_Cluster.IS_SUMS] and state[_Cluster.LEFT] == 0 and state[_Cluster.OPEN] == 0:
        push(queue.heap, time + queue.timing.answer, _DONE, cluster)
