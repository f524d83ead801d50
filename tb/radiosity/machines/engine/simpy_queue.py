"""A job in SimPy: processes for the dispatcher, the clusters, and the port, as a reference of
`radiosity.machines.engine.job_queue`.
"""

import numpy as np
import simpy

from radiosity.machines.engine.job_queue import JobSections, JobTimes
from radiosity.machines.engine.job_timing import JobTiming

__all__ = ["simpy_queue"]

# Behind all events of the same time.
_LATE = 2


def simpy_queue(sections: JobSections, timing: JobTiming, *, clusters: int, load: int) -> JobTimes:
    """The times of `radiosity.machines.engine.job_queue.run_queue`."""
    env = simpy.Environment()
    job = _Job(env, sections, timing, clusters, load)
    env.run()
    return JobTimes(load=load, **{name: np.array(times, dtype=np.int64) for name, times in job.times.items()})


class _Job:
    """What clusters share."""

    def __init__(self, env, sections, timing, clusters, load):
        self.env, self.sections, self.timing, count = env, sections, timing, len(sections.cycles)
        self.times = {name: [0] * count for name in ("cluster", "begins", "ends", "done")}
        self.free = simpy.Store(env)
        self.requests, self.came, self._last = [[] for _ in range(clusters)], env.event(), clusters - 1
        made = [_Cluster(self, number) for number in range(clusters)]
        env.process(self._dispatch(made, load + timing.first))
        env.process(self._port())

    def _dispatch(self, clusters, begin):
        yield self.env.timeout(begin)
        for cluster in clusters:
            self.free.put(cluster)
        for section in range(len(self.sections.cycles)):
            cluster = yield self.free.get()
            self.times["cluster"][section] = cluster.number
            yield self.env.timeout(self.timing.dispatch + int(self.sections.near[section]))
            self.env.process(cluster.receive(section))

    def send(self, cluster, beats):
        """A request waits for the port; the events that it has been granted, and that memory has it."""
        granted, written = self.env.event(), self.env.event()
        self.requests[cluster].append((beats, granted, written))
        if not self.came.triggered:
            self.came.succeed()
        return granted, written

    def _port(self):
        """A request of each cluster in turn."""
        count = len(self.requests)
        while True:
            chosen = next((number for number in ((self._last + 1 + offset) % count for offset in range(count))
                           if self.requests[number]), None)
            if chosen is None:
                self.came = self.env.event()
                yield self.came
                continue
            self._last = chosen
            beats, granted, written = self.requests[chosen].pop(0)
            granted.succeed()
            yield self.env.timeout(beats)
            written.succeed()
            # Requests that are made now are among those that the port chooses from.
            late = self.env.event()
            late._ok, late._value = True, None
            self.env.schedule(late, priority=_LATE)
            yield late


class _Cluster:
    """A slot, a cast, and results; each waits for the one before."""

    def __init__(self, job, number):
        self._job, self._env, self.number = job, job.env, number
        self._slot, self._free = simpy.Store(self._env), simpy.Resource(self._env, capacity=1)
        self._env.process(self._cast())

    def receive(self, section):
        """A section is in the slot after its last word."""
        yield self._env.timeout(self._job.timing.slot)
        self._slot.put(section)

    def _cast(self):
        """One section after the other."""
        job = self._job
        while True:
            section = yield self._slot.get()
            job.times["begins"][section] = self._env.now
            self._env.process(self._release(int(job.sections.free[section])))
            yield self._env.timeout(int(job.sections.cycles[section]))
            job.times["ends"][section] = self._env.now
            results = self._free.request()
            yield results
            self._env.process(self._write(section, results))
            yield self._env.timeout(job.timing.restart)

    def _release(self, cycles):
        yield self._env.timeout(cycles)
        self._job.free.put(self)

    def _write(self, section, results):
        """Hits, then sums, to the port."""
        job, timing = self._job, self._job.timing
        rays, hits = int(job.sections.rays[section]), int(job.sections.hits[section])
        window, last = simpy.Resource(self._env, capacity=timing.buffers), []
        yield self._env.timeout(timing.read_out)
        if hits:
            yield from self._send(hits, lambda beats: max(beats, beats * rays // hits), window, last)
        else:
            yield self._env.timeout(rays)
        yield self._env.timeout(timing.sums)
        yield from self._send(int(job.sections.sums[section]), lambda beats: beats, window, last)
        if last:
            yield self._env.all_of(last)
        yield self._env.timeout(timing.answer)
        job.times["done"][section] = self._env.now
        yield self._env.timeout(timing.report)
        self._free.release(results)

    def _send(self, left, cycles_of, window, last):
        """Requests are made while fewer wait for the port than there is room for."""
        while left:
            beats = min(left, self._job.timing.beats)
            room = window.request()
            yield room
            yield self._env.timeout(cycles_of(beats))
            granted, written = self._job.send(self.number, beats)
            granted.callbacks.append(lambda _, room=room: window.release(room))
            last.append(written)
            left -= beats
