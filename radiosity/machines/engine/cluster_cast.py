"""Cluster cast: the events of a cluster that casts a section, from stages of grid rays to tests.

Traversal, lists, patch filter, geometry, slots and tests are servers in a line, with a queue of limited capacity in
front of each. Each takes its items in order.
"""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import EventHeap, event_heap, next_time, pop, push
from radiosity.machines.engine.cluster_timing import ClusterTiming

__all__ = ["KEPT", "NO_CLUSTER", "ON_BUS", "OVER_NETWORK", "THROUGH_STORE", "ClusterCast", "StageItems", "add_stage",
           "apply_event", "arrive", "begin_cast", "clock", "end_cast", "fetch", "free", "last_end", "next_begin",
           "next_stage", "request_remote", "tested"]

_CELL, _CLOSE, _LIST, _FILTER, _GEOMETRY, _FREE, _DONE = range(7)
# Numbers of a cast. The front: when the next stage's first request may follow, on traversal's own clock. The shift: the
# cycles in which traversal has stalled, by which that clock is late.
(_FRONT, _SHIFT, _STALLED, _PERMITTED, _STARTED, _CLOSED, _OVER, _CELL_PENDING, _CELLS_LEFT, _CELLS_TAKEN, _LISTING,
 _ENTRIES_LEFT, _LIST_END, _ENTRIES_TAKEN, _FILTERING, _FOUND, _READ, _READING, _OFFERED, _ENTERED, _SLOTS, _READY,
 _WALKED, _DONE_COUNT, _CLOSE_PENDING, _OFFER_TIME, _QUIET, _FREED, _SELF, _AVAILABLE, _OWN, _LAST,
 _PASSED, _UNLISTED) = range(34)
# Numbers of patches that others hold, by path: found, requested and read.
_REMOTE_FOUND, _REMOTE_SENT, _REMOTE_READ, _NUMBERS = range(34, 46, 3)
# Paths to patches that others hold: clusters over the network, what no cluster holds over the bus; and the patch store
# in front of both.
OVER_NETWORK, ON_BUS, THROUGH_STORE = range(3)
# Instead of the cluster that holds a patch: none does, and the patch store has a copy.
NO_CLUSTER, KEPT = -2, -3
# States of the lists' server: nothing to do, an entry in the next cycle, no free entry behind it.
_IDLE, _BUSY, _BLOCKED = range(3)
_NEVER = -1
_EVENTS = 512
_LIMITS = ("traversal", "memory", "vertices", "setup", "walk", "pipeline", "over", "cells", "lists", "entries",
           "requests", "waiting")
(_TRAVERSAL, _MEMORY, _VERTICES, _SETUP, _WALK, _PIPELINE, _OVER_CYCLES, _CELLS, _LISTS, _ENTRIES, _REQUESTS, _WAITING,
 _ALL_SLOTS, _BEFORE_STORE, _AHEAD) = range(15)


class StageItems(NamedTuple):
    """The items of all stages so far.

    Parameters
    ----------
    time
        C int64: of each cell that grid rays meet, when its list can be read, on traversal's own clock.
    entries
        C + 1 int64: the first entry of each cell's list; a cell that is open already has none.
    is_new
        E bool: an entry is a patch that has not been found before.
    tests, owner
        P int64: of each patch that is found, in the order of discovery, cycles of its walk; and the cluster that holds
        it, -1 if this one does, `NO_CLUSTER` if none does, `KEPT` if the patch store has a copy.
    """

    time: np.ndarray
    entries: np.ndarray
    is_new: np.ndarray
    tests: np.ndarray
    owner: np.ndarray


class ClusterCast(NamedTuple):
    """A cast, which compiled functions advance.

    Parameters
    ----------
    heap
        Its events.
    numbers
        Its state.
    limits
        Latencies and capacities.
    ends
        P int64: of each patch that has entered setup, in order, the cycle in which its last ray ends.
    closes
        S int64: of each stage of requests, when its last grid ray ends, on traversal's own clock.
    ahead
        S int64: of each stage of requests, how many before it may be in flight when it begins.
    ready
        P int64: patches in the order in which they can be read.
    remote
        P x 3 int64: those that other clusters hold, those that none holds, and both where there is a patch store, in
        the order of their requests.
    """

    heap: EventHeap
    numbers: np.ndarray
    limits: np.ndarray
    ends: np.ndarray
    closes: np.ndarray
    ahead: np.ndarray
    ready: np.ndarray
    remote: np.ndarray


def begin_cast(timing: ClusterTiming, *, patches: int, barriers: np.ndarray, slots: int, run_ahead: int,
               number: int = 0, before_store: int = 0, found_ahead: int = 0) -> ClusterCast:
    """A cast at cycle 0, whose first item will be a near cell.

    Parameters
    ----------
    timing
        Latencies and capacities.
    patches
        Patches of the scene.
    barriers
        S bool: each stage waits until all before it are over; the first one is the list of near cells.
    slots, run_ahead
        ``icu.slots`` and ``ctu.run_ahead``.
    number
        The subject of its events.
    before_store
        Patches that may wait in front of the patch store. Default: there is no store.
    found_ahead
        Patches of others that may be found and not read where nothing requests them: they can be read at once.
        Default: they are requested.
    """
    numbers = np.zeros(_NUMBERS, dtype=np.int64)
    numbers[_FRONT], numbers[_STALLED], numbers[_QUIET], numbers[_FREED] = timing.begin, _NEVER, _NEVER, _NEVER
    numbers[_SELF] = number
    limits = [getattr(timing, name) for name in _LIMITS]
    # Behind the last stage there is none to wait.
    ahead = np.append(np.where(barriers[1:], 0, run_ahead), run_ahead)
    return ClusterCast(event_heap(_EVENTS), numbers,
                       np.array([*limits, slots, before_store, found_ahead], dtype=np.int64),
                       np.zeros(patches, dtype=np.int64), np.zeros(len(barriers), dtype=np.int64), ahead,
                       np.zeros(patches, dtype=np.int64), np.zeros((patches, 3), dtype=np.int64))


@compiled
def clock(cast: ClusterCast, time: int) -> int:
    """A time on traversal's own clock, which stops while traversal stalls."""
    return time - cast.numbers[_SHIFT]


@compiled
def last_end(cast: ClusterCast) -> int:
    """When the last item so far ended."""
    return cast.numbers[_LAST]


def tested(cast: ClusterCast, time: int) -> int:
    """Patches whose last ray has ended by then, the first ones in the order of discovery."""
    return int(np.searchsorted(cast.ends[:cast.numbers[_ENTERED]], time, side="right"))


def free(cast: ClusterCast) -> int:
    """When the cluster could use the next section: all requests had been accepted, and nothing was before the slots."""
    numbers = cast.numbers
    return int(numbers[_FREED] if numbers[_FREED] != _NEVER else max(numbers[_QUIET], _closed(numbers)))


@compiled
def next_stage(cast: ClusterCast, items: StageItems, generator: int) -> int:
    """Advance until the next stage's first request can be sent: the cycle in which it is.

    Parameters
    ----------
    generator
        Cycles from its permission to that request.
    """
    while True:
        begin, following = next_begin(cast, generator), next_time(cast.heap)
        if begin != _NEVER and (following == _NEVER or following > begin):
            return begin
        _advance(cast, items)


@compiled
def add_stage(cast: ClusterCast, items: StageItems, begin: int, cycles: int, near: bool) -> None:
    """A stage begins whose requests take so many cycles.

    Parameters
    ----------
    items
        With the stage's cells, whose times are those of its begin and after.
    near
        It is the list of near cells, which is no stage of requests.
    """
    numbers = cast.numbers
    numbers[_FRONT] = begin - numbers[_SHIFT] + cycles
    if not near:
        numbers[_STARTED] += 1
        cast.closes[numbers[_STARTED] - 1] = numbers[_FRONT] + cast.limits[_TRAVERSAL]
        _schedule_close(cast, begin)
    _schedule_cell(cast, items, begin)


@compiled
def next_part(cast: ClusterCast, items: StageItems) -> int:
    """Advance until the requests so far of the present stage are accepted: the cycle in which they are."""
    numbers = cast.numbers
    while True:
        begin, following = numbers[_FRONT] + numbers[_SHIFT], next_time(cast.heap)
        if numbers[_STALLED] == _NEVER and (following == _NEVER or following > begin):
            return begin
        _advance(cast, items)


@compiled
def add_part(cast: ClusterCast, items: StageItems, begin: int, cycles: int) -> None:
    """Further requests of the present stage begin, which take so many cycles."""
    numbers = cast.numbers
    numbers[_FRONT] = begin - numbers[_SHIFT] + cycles
    cast.closes[numbers[_STARTED] - 1] = numbers[_FRONT] + cast.limits[_TRAVERSAL]
    _schedule_cell(cast, items, begin)


@compiled
def end_cast(cast: ClusterCast, items: StageItems) -> int:
    """Advance until no event waits: the cycle in which the last item ended."""
    while next_time(cast.heap) != _NEVER:
        _advance(cast, items)
    return cast.numbers[_LAST]


@compiled
def _advance(cast, items):
    """One event."""
    time, kind, _ = pop(cast.heap)
    apply_event(cast, items, time, kind)


@compiled
def apply_event(cast: ClusterCast, items: StageItems, time: int, kind: int) -> None:
    """An event that was scheduled happens."""
    numbers, limits = cast.numbers, cast.limits
    if kind == _CELL:
        numbers[_CELL_PENDING] = 0
        if numbers[_CELLS_LEFT] - numbers[_PASSED] == limits[_CELLS]:
            numbers[_STALLED] = time
        else:
            _send_cell(cast, items, time)
    elif kind == _CLOSE:
        numbers[_CLOSE_PENDING] = 0
        if numbers[_STALLED] == _NEVER and time >= cast.closes[numbers[_CLOSED]] + numbers[_SHIFT]:
            numbers[_CLOSED] += 1
            _end_stages(cast, items, time)
        _schedule_close(cast, time)
    elif kind == _LIST:
        _list(cast, items, time)
    elif kind == _FILTER:
        numbers[_FILTERING] = 0
        _filter(cast, items, time)
        _end_stages(cast, items, time)
    elif kind == _GEOMETRY:
        numbers[_READING] = 0
        numbers[_OFFERED] += 1
        numbers[_OFFER_TIME] = time
        _enter(cast, items, time)
        _read(cast, items, time)
    elif kind == _FREE:
        numbers[_SLOTS] -= 1
        _enter(cast, items, time)
        _read(cast, items, time)
    else:
        numbers[_DONE_COUNT] += 1
        _end_stages(cast, items, time)
    _watch(cast, time)


@compiled
def request_remote(cast: ClusterCast, items: StageItems, time: int, path: int, most: int) -> int:
    """Take the next patch to request on a path; -1 if there is none, or ``most`` have not been read yet.

    Parameters
    ----------
    path
        `OVER_NETWORK`, `ON_BUS` or `THROUGH_STORE`.
    """
    numbers = cast.numbers
    number = numbers[_REMOTE_SENT + path]
    if number == numbers[_REMOTE_FOUND + path] or number - numbers[_REMOTE_READ + path] == most:
        return _NEVER
    numbers[_REMOTE_SENT + path] += 1
    _wake_filter(cast, time)
    return cast.remote[number, path]


@compiled
def fetch(cast: ClusterCast, items: StageItems, patch: int) -> None:
    """The patch store does not have a patch: it is requested where it is."""
    path = _path(items, patch)
    cast.remote[cast.numbers[_REMOTE_FOUND + path], path] = patch
    cast.numbers[_REMOTE_FOUND + path] += 1


@compiled
def arrive(cast: ClusterCast, items: StageItems, time: int, patch: int) -> None:
    """A patch that another cluster or none holds has arrived."""
    _make_ready(cast, patch)
    _read(cast, items, time)


@compiled
def next_begin(cast: ClusterCast, permission: int) -> int:
    """When the next stage may begin, as far as is known; -1 if something has to happen before.

    Parameters
    ----------
    permission
        Cycles from the permission of the stage to its first request.
    """
    numbers = cast.numbers
    if numbers[_STARTED] - numbers[_OVER] > cast.ahead[numbers[_STARTED]] or numbers[_STALLED] != _NEVER:
        return _NEVER
    return max(numbers[_FRONT] + numbers[_SHIFT], numbers[_PERMITTED] + permission)


@compiled
def _closed(numbers):
    """When the last request that is known is accepted."""
    return numbers[_FRONT] + numbers[_SHIFT]


@compiled
def _watch(cast, time):
    """Times in which no cell and no patch is before the slots."""
    numbers = cast.numbers
    is_quiet = (numbers[_LISTING] == _IDLE and not numbers[_FILTERING] and numbers[_CELLS_TAKEN] == numbers[_CELLS_LEFT]
                and numbers[_ENTRIES_TAKEN] == numbers[_ENTRIES_LEFT] and numbers[_ENTERED] == numbers[_FOUND])
    if is_quiet == (numbers[_QUIET] != _NEVER):
        return
    # The last stage of requests has begun, and a time without cells and patches has been long enough.
    begin = max(numbers[_QUIET], _closed(numbers))
    if not is_quiet and numbers[_FREED] == _NEVER and numbers[_STARTED] == len(cast.closes) - 1 and time > begin:
        numbers[_FREED] = begin
    numbers[_QUIET] = time if is_quiet else _NEVER


@compiled
def _schedule_cell(cast, items, now):
    """The next cell leaves traversal when its time has come."""
    numbers = cast.numbers
    if numbers[_CELL_PENDING] or numbers[_STALLED] != _NEVER or numbers[_CELLS_LEFT] == len(items.time):
        return
    numbers[_CELL_PENDING] = 1
    push(cast.heap, max(now, items.time[numbers[_CELLS_LEFT]] + numbers[_SHIFT]), _CELL, cast.numbers[_SELF])


@compiled
def _schedule_close(cast, now):
    """The oldest stage closes when its last grid ray has ended; stalls delay it."""
    numbers = cast.numbers
    if numbers[_CLOSE_PENDING] or numbers[_STALLED] != _NEVER or numbers[_CLOSED] == numbers[_STARTED]:
        return
    numbers[_CLOSE_PENDING] = 1
    push(cast.heap, max(now, cast.closes[numbers[_CLOSED]] + numbers[_SHIFT]), _CLOSE, cast.numbers[_SELF])


@compiled
def _send_cell(cast, items, time):
    cast.numbers[_CELLS_LEFT] += 1
    _pass_cells(cast, items)
    _schedule_cell(cast, items, time)
    if cast.numbers[_LISTING] == _IDLE:
        _list(cast, items, time)


@compiled
def _pass_cells(cast, items):
    """The cell filter discards cells that are open; others wait behind it for their lists, so many at most."""
    numbers = cast.numbers
    while numbers[_PASSED] < numbers[_CELLS_LEFT]:
        cell = numbers[_PASSED]
        if items.entries[cell] < items.entries[cell + 1]:
            if numbers[_UNLISTED] == cast.limits[_LISTS]:
                return
            numbers[_UNLISTED] += 1
        numbers[_PASSED] += 1


@compiled
def _list(cast, items, time):
    """An entry of the present cell's list, or of the next one's."""
    numbers, limits = cast.numbers, cast.limits
    numbers[_LISTING] = _IDLE
    if numbers[_ENTRIES_LEFT] == numbers[_LIST_END]:
        while numbers[_CELLS_TAKEN] < numbers[_PASSED] and numbers[_ENTRIES_LEFT] == numbers[_LIST_END]:
            numbers[_CELLS_TAKEN] += 1
            numbers[_LIST_END] = items.entries[numbers[_CELLS_TAKEN]]
        if numbers[_ENTRIES_LEFT] == numbers[_LIST_END]:
            _end_stages(cast, items, time)
            return
        numbers[_UNLISTED] -= 1
        _pass_cells(cast, items)
        if numbers[_STALLED] != _NEVER and numbers[_CELLS_LEFT] - numbers[_PASSED] < limits[_CELLS]:
            numbers[_SHIFT] += time - numbers[_STALLED]
            numbers[_STALLED] = _NEVER
            numbers[_CELLS_LEFT] += 1
            _pass_cells(cast, items)
            _schedule_cell(cast, items, time + 1)
            _schedule_close(cast, time)
    if numbers[_ENTRIES_LEFT] < numbers[_LIST_END]:
        if numbers[_ENTRIES_LEFT] - numbers[_ENTRIES_TAKEN] == limits[_ENTRIES]:
            numbers[_LISTING] = _BLOCKED
            return
        numbers[_ENTRIES_LEFT] += 1
        _filter(cast, items, time)
    numbers[_LISTING] = _BUSY
    push(cast.heap, time + 1, _LIST, cast.numbers[_SELF])


@compiled
def _filter(cast, items, time):
    """The patch filter takes an entry in each cycle; a patch that is found needs a free entry behind it."""
    numbers = cast.numbers
    entry = numbers[_ENTRIES_TAKEN]
    if numbers[_FILTERING] or entry == numbers[_ENTRIES_LEFT]:
        return
    if items.is_new[entry] and not _find(cast, items):
        return
    numbers[_ENTRIES_TAKEN] += 1
    numbers[_FILTERING] = 1
    push(cast.heap, time + 1, _FILTER, cast.numbers[_SELF])
    if numbers[_LISTING] == _BLOCKED:
        numbers[_LISTING] = _BUSY
        push(cast.heap, time, _LIST, cast.numbers[_SELF])
    _read(cast, items, time)


@compiled
def _find(cast, items):
    """A patch is found, and requested where it is, if the queue of requests there is not full: whether it is."""
    numbers, most, patch = cast.numbers, cast.limits[_REQUESTS], cast.numbers[_FOUND]
    path = _path(items, patch)
    if path != _NEVER and cast.limits[_AHEAD]:
        if numbers[_REMOTE_FOUND + path] - numbers[_REMOTE_READ + path] == cast.limits[_AHEAD]:
            return False
        numbers[_FOUND] += 1
        numbers[_REMOTE_FOUND + path] += 1
        _make_ready(cast, patch)
        return True
    if path != _NEVER and cast.limits[_BEFORE_STORE]:
        path, most = THROUGH_STORE, cast.limits[_BEFORE_STORE]
    if (numbers[_OWN] if path == _NEVER else numbers[_REMOTE_FOUND + path] - numbers[_REMOTE_SENT + path]) == most:
        return False
    numbers[_FOUND] += 1
    if path == _NEVER:
        numbers[_OWN] += 1
        _make_ready(cast, patch)
    else:
        cast.remote[numbers[_REMOTE_FOUND + path], path] = patch
        numbers[_REMOTE_FOUND + path] += 1
    return True


@compiled
def _path(items, patch):
    """The path by which a patch comes, -1 of an own one."""
    owner = items.owner[patch]
    if owner >= 0:
        return OVER_NETWORK
    return ON_BUS if owner == NO_CLUSTER else THROUGH_STORE if owner == KEPT else _NEVER


@compiled
def _make_ready(cast, patch):
    """A patch can be read."""
    cast.ready[cast.numbers[_AVAILABLE]] = patch
    cast.numbers[_AVAILABLE] += 1


@compiled
def _read(cast, items, time):
    """The vertices of the next patch are read, one in each cycle."""
    numbers, limits = cast.numbers, cast.limits
    if (numbers[_READING] or numbers[_READ] == numbers[_AVAILABLE]
            or numbers[_OFFERED] - numbers[_ENTERED] == limits[_WAITING]):
        return
    path = _path(items, cast.ready[numbers[_READ]])
    if path == _NEVER:
        numbers[_OWN] -= 1
    else:
        numbers[_REMOTE_READ + path] += 1
        if limits[_BEFORE_STORE] and path != THROUGH_STORE:
            numbers[_REMOTE_READ + THROUGH_STORE] += 1
    numbers[_READ] += 1
    numbers[_READING] = 1
    push(cast.heap, time + limits[_VERTICES], _GEOMETRY, cast.numbers[_SELF])
    _wake_filter(cast, time)


@compiled
def _wake_filter(cast, time):
    """The patch filter may have waited for a free entry behind it."""
    numbers = cast.numbers
    if not numbers[_FILTERING] and numbers[_ENTRIES_TAKEN] < numbers[_ENTRIES_LEFT]:
        numbers[_FILTERING] = 1
        push(cast.heap, time, _FILTER, numbers[_SELF])


@compiled
def _enter(cast, items, time):
    """Patches that wait enter setup while slots are free."""
    numbers, limits = cast.numbers, cast.limits
    while numbers[_ENTERED] < numbers[_OFFERED] and numbers[_SLOTS] < limits[_ALL_SLOTS]:
        patch, place = cast.ready[numbers[_ENTERED]], numbers[_ENTERED]
        # The vertices of a patch that has not waited have entered while they were read.
        waited = numbers[_OFFERED] - place > 1 or numbers[_OFFER_TIME] < time
        last_vertex = time + limits[_VERTICES] if waited else time
        numbers[_ENTERED] += 1
        numbers[_SLOTS] += 1
        numbers[_READY] = max(last_vertex + limits[_SETUP], numbers[_READY] + limits[_VERTICES])
        numbers[_WALKED] = max(numbers[_READY], numbers[_WALKED]) + items.tests[patch]
        last_ray = numbers[_WALKED] + limits[_WALK]
        push(cast.heap, last_ray, _FREE, cast.numbers[_SELF])
        cast.ends[place] = last_ray + limits[_PIPELINE]
        push(cast.heap, cast.ends[place], _DONE, cast.numbers[_SELF])


@compiled
def _end_stages(cast, items, time):
    """All closed stages are over when no cell and no patch is in flight."""
    numbers, limits = cast.numbers, cast.limits
    cell = numbers[_CELLS_LEFT]
    if (numbers[_LISTING] != _IDLE or numbers[_CELLS_TAKEN] != cell
            or numbers[_ENTRIES_TAKEN] != numbers[_ENTRIES_LEFT] or numbers[_DONE_COUNT] != numbers[_FOUND]
            or (cell < len(items.time) and items.time[cell] + numbers[_SHIFT] - limits[_MEMORY] <= time)):
        return
    numbers[_LAST] = time
    if numbers[_CLOSED] > numbers[_OVER] and numbers[_STARTED] - numbers[_OVER] > cast.ahead[numbers[_STARTED]]:
        numbers[_PERMITTED] = time + limits[_OVER_CYCLES]
    numbers[_OVER] = numbers[_CLOSED]
