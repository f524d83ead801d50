"""A cluster's cast in SimPy: a process for each server, as a reference of `radiosity.machines.engine.cluster_cast`."""

from collections import deque

import numpy as np
import simpy

from radiosity.machines.engine.section_trace import CastTimes

__all__ = ["SimpyCluster"]

# Behind all events of the same time.
_LATE = 2


class SimpyCluster:
    """Servers that wait for any change of the state.

    Parameters
    ----------
    env
        SimPy's environment, whose time is in cycles.
    trace, timing, slots, run_ahead
        See `radiosity.machines.engine.section_trace.replay`.
    owner
        P int, the cluster that holds each patch, in the order of discovery; -1 if this one does, -2 if none does, -3
        if the patch store has a copy. Default: this one holds all.
    asks
        Of the network and of the bus, and of copies in the patch store: called with each patch that is requested there;
        `arrive` answers.
    most
        Of both, and of the patch store: patches that are requested and not read, at most.
    store
        The timing of the patch store, which patches of others pass. Default: there is none.
    """

    def __init__(self, env, trace, timing, slots, run_ahead, *, owner=None, asks=(None, None, None), most=(1, 1, 1),
                 store=None):
        self._store = store
        self._owner, self._asks, self._most = [-1] * len(trace.tests) if owner is None else owner, asks, most
        self._env, self._trace, self._timing, self._all_slots, self._run_ahead = env, trace, timing, slots, run_ahead
        self._change = env.event()
        self.begins, self.ends, self.last = [], [0] * len(trace.tests), 0
        # Traversal's clock is late by the shift. Cells that are known, with their times on it.
        self._shift, self._stalled, self._known, self._sent = 0, False, [], 0
        self._closes, self._closed, self._over, self._permitted = [], 0, 0, 0
        self._cells, self._unlisted, self._listing, self._entries, self._waiting = deque(), deque(), False, deque(), []
        # Patches that can be read, own ones among them; those that are not requested yet, and those that are.
        self._ready, self._own, self._queued, self._outstanding = deque(), 0, (deque(), deque(), deque()), [0, 0, 0]
        self._slots, self._windows, self._found, self._done = 0, simpy.Store(env), 0, 0
        # Traversal's clock when it has accepted all known requests. Before the slots: whether the patch filter has an
        # entry, patches that have entered setup, since when there are no cells and patches, and the first such time at
        # the end.
        self._accepted, self._filtering, self._entered, self._quiet, self._free = timing.begin, False, 0, None, None
        for process in (self._front, self._traversal, self._close, self._list, self._filter, self._geometry,
                        self._setup, self._walk):
            env.process(process())
        for path in range(2):
            env.process(self._request(path))
        if store:
            env.process(self._look_up())

    def times(self):
        """The times of the cast when all has happened."""
        return CastTimes(begins=np.array(self.begins), ends=np.array(self.ends), free=self.free(),
                         cycles=self.last + self._timing.over + self._timing.end)

    def arrive(self, patch):
        """A patch that another cluster or none holds has arrived."""
        self._ready.append(patch)
        self._changed()

    def _changed(self):
        """Something has changed: all servers look again."""
        before, self._change = self._change, self._env.event()
        before.succeed()
        self._watch()
        self._end_stages()

    def _watch(self):
        """Times in which no cell and no patch is before the slots."""
        is_quiet = not (self._listing or self._filtering or self._cells or self._unlisted or self._entries
                        or self._entered < self._found)
        if is_quiet == (self._quiet is not None):
            return
        if not is_quiet and self._free is None and len(self._closes) == len(self._trace.cycles) - 1:
            begin = max(self._quiet, self._accepted + self._shift)
            self._free = begin if self._env.now > begin else None
        self._quiet = self._env.now if is_quiet else None

    def free(self):
        """When the cluster could use the next section."""
        return self._free or max(self._quiet, self._accepted + self._shift)

    def _until(self, condition):
        while not condition():
            yield self._change

    def _clock(self, due):
        """Until traversal's clock shows a time."""
        while self._stalled or self._env.now < due() + self._shift:
            if self._stalled:
                yield self._change
            else:
                yield self._env.timeout(due() + self._shift - self._env.now)

    def _front(self):
        """The stages begin."""
        front = self._timing.begin
        for stage in range(len(self._trace.cycles)):
            wait = self._timing.generator + int(self._trace.searches[stage]) if stage else 0

            def may_begin(stage=stage, front=front, wait=wait):
                return (not self._stalled and len(self._closes) - self._over <= self._ahead(stage)
                        and self._env.now >= max(front + self._shift, self._permitted + wait if wait else 0))

            while not may_begin():
                due = max(front + self._shift, self._permitted + wait)
                if due > self._env.now and not self._stalled:
                    yield self._env.any_of([self._change, self._env.timeout(due - self._env.now)])
                else:
                    yield self._change
                # All else that happens now happens before.
                late = self._env.event()
                late._ok, late._value = True, None
                self._env.schedule(late, priority=_LATE)
                yield late
            front = self._begin(stage)

    def _ahead(self, stage):
        """Stages before a stage that may be in flight when it begins."""
        is_barrier = self._trace.is_barrier
        return 0 if stage < len(is_barrier) and is_barrier[stage] else self._run_ahead

    def _begin(self, stage):
        trace, timing, begin = self._trace, self._timing, self._env.now
        self.begins.append(begin)
        first, end = trace.first_cell[stage:stage + 2]
        latency = timing.memory + (timing.traversal if stage else 0)
        self._known.extend(int(begin - self._shift + latency + offset) for offset in trace.offset[first:end])
        front = begin - self._shift + int(trace.cycles[stage])
        if stage:
            self._closes.append(front + timing.traversal)
        self._accepted = front
        self._changed()
        return front

    def _close(self):
        """Stages close in order."""
        while True:
            yield from self._until(lambda: self._closed < len(self._closes))
            yield from self._clock(lambda: self._closes[self._closed])
            self._closed += 1
            self._changed()

    def _traversal(self):
        """Cells leave one after the other, and stall while their queue is full."""
        while True:
            yield from self._until(lambda: self._sent < len(self._known))
            yield from self._clock(lambda: self._known[self._sent])
            since = self._env.now
            if len(self._cells) == self._timing.cells:
                self._stalled = True
                yield from self._until(lambda: len(self._cells) < self._timing.cells)
                self._shift += self._env.now - since
                self._stalled = False
            self._cells.append(self._sent)
            self._sent += 1
            self._pass_cells()
            self._changed()
            if self._env.now > since:
                yield self._env.timeout(1)

    def _pass_cells(self):
        """The cell filter discards cells without entries, which are open; others need an entry behind it."""
        while self._cells:
            entries = range(*self._trace.entries[self._cells[0]:self._cells[0] + 2])
            if entries and len(self._unlisted) == self._timing.lists:
                return
            self._cells.popleft()
            if entries:
                self._unlisted.append(entries)

    def _list(self):
        """Entries of the cells' lists, one in each cycle."""
        while True:
            yield from self._until(lambda: self._unlisted)
            self._listing, entries = True, self._unlisted.popleft()
            self._pass_cells()
            self._changed()
            for entry in entries:
                yield from self._until(lambda: len(self._entries) < self._timing.entries)
                self._entries.append(entry)
                self._changed()
                yield self._env.timeout(1)
            self._listing = bool(self._unlisted)
            self._changed()

    def _filter(self):
        """An entry in each cycle; a patch that is found needs an entry behind it."""
        def can_pass():
            if not self._entries or not self._trace.is_new[self._entries[0]]:
                return bool(self._entries)
            path = self._first(self._found)
            most = self._store.waiting if path == 2 else self._timing.requests
            return (self._own if path is None else len(self._queued[path])) < most
        while True:
            yield from self._until(can_pass)
            if self._trace.is_new[self._entries.popleft()]:
                path = self._first(self._found)
                self._own += path is None
                (self._ready if path is None else self._queued[path]).append(self._found)
                self._found += 1
            self._filtering = True
            self._changed()
            yield self._env.timeout(1)
            self._filtering = False
            self._changed()

    def _path(self, patch):
        """0 of patches of other clusters, 1 of those that no cluster holds, 2 of copies, None of own ones."""
        owner = self._owner[patch]
        return 0 if owner >= 0 else {-1: None, -2: 1, -3: 2}[owner]

    def _first(self, patch):
        """Where a patch is looked for first."""
        path = self._path(patch)
        return 2 if self._store and path is not None else path

    def _look_up(self):
        """Lookups in the patch store, one after the other; what it has not is requested where it is."""
        while True:
            yield from self._until(lambda: self._queued[2] and self._outstanding[2] < self._most[2])
            self._outstanding[2] += 1
            patch = self._queued[2].popleft()
            self._changed()
            yield self._env.timeout(self._store.lookup)
            path = self._path(patch)
            if path == 2:
                self._asks[2](patch)
            else:
                self._queued[path].append(patch)
            self._changed()

    def _request(self, path):
        """Requests on one of both paths."""
        while True:
            yield from self._until(lambda: self._queued[path] and self._outstanding[path] < self._most[path])
            self._outstanding[path] += 1
            self._asks[path](self._queued[path].popleft())
            self._changed()

    def _geometry(self):
        """The vertices of a patch, one in each cycle."""
        while True:
            yield from self._until(lambda: self._ready and len(self._waiting) < self._timing.waiting)
            patch = self._ready.popleft()
            path = self._path(patch)
            if path is None:
                self._own -= 1
            else:
                self._outstanding[path] -= 1
                self._outstanding[2] -= path != 2 and self._store is not None
            self._changed()
            yield self._env.timeout(self._timing.vertices)
            self._waiting.append((patch, self._env.now))
            self._changed()

    def _setup(self):
        """A slot for each patch, then its window."""
        timing, ready = self._timing, 0
        while True:
            yield from self._until(lambda: self._waiting and self._slots < self._all_slots)
            patch, offered = self._waiting.pop(0)
            self._entered += 1
            self._slots += 1
            last_vertex = self._env.now + (timing.vertices if offered < self._env.now else 0)
            ready = max(last_vertex + timing.setup, ready + timing.vertices)
            self._windows.put((patch, self._entered - 1, ready))
            self._changed()

    def _walk(self):
        """Windows one after the other."""
        while True:
            patch, place, ready = yield self._windows.get()
            yield self._env.timeout(max(0, ready - self._env.now))
            yield self._env.timeout(int(self._trace.tests[patch]))
            self._env.process(self._end(place))

    def _end(self, place):
        """The slot is free with the last ray; the patch has ended a pipeline later."""
        yield self._env.timeout(self._timing.walk)
        self._slots -= 1
        self._changed()
        yield self._env.timeout(self._timing.pipeline)
        self.ends[place] = self._env.now
        self._done += 1
        self._changed()

    def _end_stages(self):
        """All closed stages are over when no cell and no patch is in flight."""
        near = self._sent < len(self._known) and (
            self._known[self._sent] + self._shift - self._timing.memory <= self._env.now)
        if (near or self._stalled or self._cells or self._unlisted or self._listing or self._entries
                or self._done < self._found):
            return
        self.last = self._env.now
        if self._closed > self._over and len(self._closes) - self._over > self._ahead(len(self._closes) + 1):
            self._permitted = self._env.now + self._timing.over
        self._over = self._closed
