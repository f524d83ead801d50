"""Cluster cast: the events of a cluster that casts a section, from stages of grid rays to tests.

Traversal, lists, patch filter, geometry, slots and tests are servers in a line, with a queue of limited capacity in
front of each. Each takes its items in order.
"""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import EventHeap, event_heap, next_time, pop, push
from radiosity.machines.engine.cluster_timing import ClusterTiming

__all__ = ["KEPT", "NO_CLUSTER", "ON_BUS", "OVER_NETWORK", "THROUGH_STORE", "ClusterCast", "StageItems", "add_stage",
           "apply_event", "arrive", "begin_cast", "clock", "end_cast", "fetch", "free", "last_end", "next_begin",
           "next_stage", "request_remote", "tested"]

_Event = columns("_Event", "CELL CLOSE LIST FILTER GEOMETRY FREE DONE")
# The front: when the next stage's first request may follow, on traversal's own clock. The shift: the cycles in which
# traversal has stalled, by which that clock is late. Of patches that others hold there are three numbers each, one for
# each path: found, requested and read.
_Cast = columns("_Cast", "FRONT SHIFT STALLED PERMITTED STARTED CLOSED OVER CELL_PENDING CELLS_LEFT CELLS_TAKEN "
                "LISTING ENTRIES_LEFT LIST_END ENTRIES_TAKEN FILTERING FOUND READ READING OFFERED ENTERED SLOTS READY "
                "WALKED DONE_COUNT CLOSE_PENDING OFFER_TIME QUIET FREED SELF AVAILABLE OWN LAST PASSED UNLISTED "
                "REMOTE_FOUND REMOTE_SENT REMOTE_READ END", (*range(34), *range(34, 46, 3)))
# Paths to patches that others hold: clusters over the network, what no cluster holds over the bus; and the patch store
# in front of both.
OVER_NETWORK, ON_BUS, THROUGH_STORE = range(3)
# Instead of the cluster that holds a patch: none does, and the patch store has a copy.
NO_CLUSTER, KEPT = -2, -3
# States of the lists' server: nothing to do, an entry in the next cycle, no free entry behind it.
_Lists = columns("_Lists", "IDLE BUSY BLOCKED")
_NEVER = -1
_EVENTS = 512
# Numbers of `ClusterTiming`, and others behind them.
_Limit = columns("_Limit", "TRAVERSAL MEMORY VERTICES SETUP WALK PIPELINE OVER CELLS LISTS ENTRIES REQUESTS WAITING "
                 "ALL_SLOTS BEFORE_STORE AHEAD")


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
    numbers = np.zeros(_Cast.END, dtype=np.int64)
    numbers[[_Cast.STALLED, _Cast.QUIET, _Cast.FREED]] = _NEVER
    numbers[_Cast.FRONT], numbers[_Cast.SELF] = timing.begin, number
    limits = [getattr(timing, name.lower()) for name in _Limit._fields[:_Limit.ALL_SLOTS]]
    # Behind the last stage there is none to wait.
    ahead = np.append(np.where(barriers[1:], 0, run_ahead), run_ahead)
    return ClusterCast(event_heap(_EVENTS), numbers,
                       np.array([*limits, slots, before_store, found_ahead], dtype=np.int64),
                       np.zeros(patches, dtype=np.int64), np.zeros(len(barriers), dtype=np.int64), ahead,
                       np.zeros(patches, dtype=np.int64), np.zeros((patches, 3), dtype=np.int64))


@compiled
def clock(cast: ClusterCast, time: int) -> int:
    """A time on traversal's own clock, which stops while traversal stalls."""
    return time - cast.numbers[_Cast.SHIFT]


@compiled
def last_end(cast: ClusterCast) -> int:
    """When the last item so far ended."""
    return cast.numbers[_Cast.LAST]


def tested(cast: ClusterCast, time: int) -> int:
    """Patches whose last ray has ended by then, the first ones in the order of discovery."""
    return int(np.searchsorted(cast.ends[:cast.numbers[_Cast.ENTERED]], time, side="right"))


def free(cast: ClusterCast) -> int:
    """When the cluster could use the next section: all requests had been accepted, and nothing was before the slots."""
    numbers = cast.numbers
    return int(numbers[_Cast.FREED] if numbers[_Cast.FREED] != _NEVER else max(numbers[_Cast.QUIET], _closed(numbers)))


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
    numbers[_Cast.FRONT] = begin - numbers[_Cast.SHIFT] + cycles
    if not near:
        numbers[_Cast.STARTED] += 1
        cast.closes[numbers[_Cast.STARTED] - 1] = numbers[_Cast.FRONT] + cast.limits[_Limit.TRAVERSAL]
        _schedule_close(cast, begin)
    _schedule_cell(cast, items, begin)


@compiled
def next_part(cast: ClusterCast, items: StageItems) -> int:
    """Advance until the requests so far of the present stage are accepted: the cycle in which they are."""
    numbers = cast.numbers
    while True:
        begin, following = numbers[_Cast.FRONT] + numbers[_Cast.SHIFT], next_time(cast.heap)
        if numbers[_Cast.STALLED] == _NEVER and (following == _NEVER or following > begin):
            return begin
        _advance(cast, items)


@compiled
def add_part(cast: ClusterCast, items: StageItems, begin: int, cycles: int) -> None:
    """Further requests of the present stage begin, which take so many cycles."""
    numbers = cast.numbers
    numbers[_Cast.FRONT] = begin - numbers[_Cast.SHIFT] + cycles
    cast.closes[numbers[_Cast.STARTED] - 1] = numbers[_Cast.FRONT] + cast.limits[_Limit.TRAVERSAL]
    _schedule_cell(cast, items, begin)


@compiled
def end_cast(cast: ClusterCast, items: StageItems) -> int:
    """Advance until no event waits: the cycle in which the last item ended."""
    while next_time(cast.heap) != _NEVER:
        _advance(cast, items)
    return cast.numbers[_Cast.LAST]


@compiled
def _advance(cast, items):
    """One event."""
    time, kind, _ = pop(cast.heap)
    apply_event(cast, items, time, kind)


@compiled
def apply_event(cast: ClusterCast, items: StageItems, time: int, kind: int) -> None:
    """An event that was scheduled happens."""
    numbers, limits = cast.numbers, cast.limits
    if kind == _Event.CELL:
        numbers[_Cast.CELL_PENDING] = 0
        if numbers[_Cast.CELLS_LEFT] - numbers[_Cast.PASSED] == limits[_Limit.CELLS]:
            numbers[_Cast.STALLED] = time
        else:
            _send_cell(cast, items, time)
    elif kind == _Event.CLOSE:
        numbers[_Cast.CLOSE_PENDING] = 0
        if numbers[_Cast.STALLED] == _NEVER and time >= cast.closes[numbers[_Cast.CLOSED]] + numbers[_Cast.SHIFT]:
            numbers[_Cast.CLOSED] += 1
            _end_stages(cast, items, time)
        _schedule_close(cast, time)
    elif kind == _Event.LIST:
        _list(cast, items, time)
    elif kind == _Event.FILTER:
        numbers[_Cast.FILTERING] = 0
        _filter(cast, items, time)
        _end_stages(cast, items, time)
    elif kind == _Event.GEOMETRY:
        numbers[_Cast.READING] = 0
        numbers[_Cast.OFFERED] += 1
        numbers[_Cast.OFFER_TIME] = time
        _enter(cast, items, time)
        _read(cast, items, time)
    elif kind == _Event.FREE:
        numbers[_Cast.SLOTS] -= 1
        _enter(cast, items, time)
        _read(cast, items, time)
    else:
        numbers[_Cast.DONE_COUNT] += 1
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
    number = numbers[_Cast.REMOTE_SENT + path]
    if number == numbers[_Cast.REMOTE_FOUND + path] or number - numbers[_Cast.REMOTE_READ + path] == most:
        return _NEVER
    numbers[_Cast.REMOTE_SENT + path] += 1
    _wake_filter(cast, time)
    return cast.remote[number, path]


@compiled
def fetch(cast: ClusterCast, items: StageItems, patch: int) -> None:
    """The patch store does not have a patch: it is requested where it is."""
    path = _path(items, patch)
    cast.remote[cast.numbers[_Cast.REMOTE_FOUND + path], path] = patch
    cast.numbers[_Cast.REMOTE_FOUND + path] += 1


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
    if numbers[_Cast.STALLED] != _NEVER or _must_wait(cast):
        return _NEVER
    return max(numbers[_Cast.FRONT] + numbers[_Cast.SHIFT], numbers[_Cast.PERMITTED] + permission)


@compiled
def _must_wait(cast):
    """Whether more stages are in flight than may be when the next one begins."""
    started = cast.numbers[_Cast.STARTED]
    return started - cast.numbers[_Cast.OVER] > cast.ahead[started]


@compiled
def _closed(numbers):
    """When the last request that is known is accepted."""
    return numbers[_Cast.FRONT] + numbers[_Cast.SHIFT]


@compiled
def _watch(cast, time):
    """Times in which no cell and no patch is before the slots."""
    numbers = cast.numbers
    is_quiet = (numbers[_Cast.LISTING] == _Lists.IDLE and not numbers[_Cast.FILTERING]
                and numbers[_Cast.CELLS_TAKEN] == numbers[_Cast.CELLS_LEFT]
                and numbers[_Cast.ENTRIES_TAKEN] == numbers[_Cast.ENTRIES_LEFT]
                and numbers[_Cast.ENTERED] == numbers[_Cast.FOUND])
    if is_quiet == (numbers[_Cast.QUIET] != _NEVER):
        return
    # The last stage of requests has begun, and a time without cells and patches has been long enough.
    begin = max(numbers[_Cast.QUIET], _closed(numbers))
    has_all = numbers[_Cast.STARTED] == len(cast.closes) - 1
    if not is_quiet and numbers[_Cast.FREED] == _NEVER and has_all and time > begin:
        numbers[_Cast.FREED] = begin
    numbers[_Cast.QUIET] = time if is_quiet else _NEVER


@compiled
def _schedule_cell(cast, items, now):
    """The next cell leaves traversal when its time has come."""
    numbers = cast.numbers
    if numbers[_Cast.CELL_PENDING] or numbers[_Cast.STALLED] != _NEVER or numbers[_Cast.CELLS_LEFT] == len(items.time):
        return
    numbers[_Cast.CELL_PENDING] = 1
    leaves = items.time[numbers[_Cast.CELLS_LEFT]] + numbers[_Cast.SHIFT]
    push(cast.heap, max(now, leaves), _Event.CELL, numbers[_Cast.SELF])


@compiled
def _schedule_close(cast, now):
    """The oldest stage closes when its last grid ray has ended; stalls delay it."""
    numbers = cast.numbers
    closed = numbers[_Cast.CLOSED]
    if numbers[_Cast.CLOSE_PENDING] or numbers[_Cast.STALLED] != _NEVER or closed == numbers[_Cast.STARTED]:
        return
    numbers[_Cast.CLOSE_PENDING] = 1
    push(cast.heap, max(now, cast.closes[closed] + numbers[_Cast.SHIFT]), _Event.CLOSE, numbers[_Cast.SELF])


@compiled
def _send_cell(cast, items, time):
    cast.numbers[_Cast.CELLS_LEFT] += 1
    _pass_cells(cast, items)
    _schedule_cell(cast, items, time)
    if cast.numbers[_Cast.LISTING] == _Lists.IDLE:
        _list(cast, items, time)


@compiled
def _pass_cells(cast, items):
    """The cell filter discards cells that are open; others wait behind it for their lists, so many at most."""
    numbers = cast.numbers
    while numbers[_Cast.PASSED] < numbers[_Cast.CELLS_LEFT]:
        cell = numbers[_Cast.PASSED]
        if items.entries[cell] < items.entries[cell + 1]:
            if numbers[_Cast.UNLISTED] == cast.limits[_Limit.LISTS]:
                return
            numbers[_Cast.UNLISTED] += 1
        numbers[_Cast.PASSED] += 1


@compiled
def _list(cast, items, time):
    """An entry of the present cell's list, or of the next one's."""
    numbers, limits = cast.numbers, cast.limits
    numbers[_Cast.LISTING] = _Lists.IDLE
    if numbers[_Cast.ENTRIES_LEFT] == numbers[_Cast.LIST_END]:
        while (numbers[_Cast.CELLS_TAKEN] < numbers[_Cast.PASSED]
               and numbers[_Cast.ENTRIES_LEFT] == numbers[_Cast.LIST_END]):
            numbers[_Cast.CELLS_TAKEN] += 1
            numbers[_Cast.LIST_END] = items.entries[numbers[_Cast.CELLS_TAKEN]]
        if numbers[_Cast.ENTRIES_LEFT] == numbers[_Cast.LIST_END]:
            _end_stages(cast, items, time)
            return
        numbers[_Cast.UNLISTED] -= 1
        _pass_cells(cast, items)
        unpassed = numbers[_Cast.CELLS_LEFT] - numbers[_Cast.PASSED]
        if numbers[_Cast.STALLED] != _NEVER and unpassed < limits[_Limit.CELLS]:
            numbers[_Cast.SHIFT] += time - numbers[_Cast.STALLED]
            numbers[_Cast.STALLED] = _NEVER
            numbers[_Cast.CELLS_LEFT] += 1
            _pass_cells(cast, items)
            _schedule_cell(cast, items, time + 1)
            _schedule_close(cast, time)
    if numbers[_Cast.ENTRIES_LEFT] < numbers[_Cast.LIST_END]:
        if numbers[_Cast.ENTRIES_LEFT] - numbers[_Cast.ENTRIES_TAKEN] == limits[_Limit.ENTRIES]:
            numbers[_Cast.LISTING] = _Lists.BLOCKED
            return
        numbers[_Cast.ENTRIES_LEFT] += 1
        _filter(cast, items, time)
    numbers[_Cast.LISTING] = _Lists.BUSY
    push(cast.heap, time + 1, _Event.LIST, cast.numbers[_Cast.SELF])


@compiled
def _filter(cast, items, time):
    """The patch filter takes an entry in each cycle; a patch that is found needs a free entry behind it."""
    numbers = cast.numbers
    entry = numbers[_Cast.ENTRIES_TAKEN]
    if numbers[_Cast.FILTERING] or entry == numbers[_Cast.ENTRIES_LEFT]:
        return
    if items.is_new[entry] and not _find(cast, items):
        return
    numbers[_Cast.ENTRIES_TAKEN] += 1
    numbers[_Cast.FILTERING] = 1
    push(cast.heap, time + 1, _Event.FILTER, cast.numbers[_Cast.SELF])
    if numbers[_Cast.LISTING] == _Lists.BLOCKED:
        numbers[_Cast.LISTING] = _Lists.BUSY
        push(cast.heap, time, _Event.LIST, cast.numbers[_Cast.SELF])
    _read(cast, items, time)


@compiled
def _find(cast, items):
    """A patch is found, and requested where it is, if the queue of requests there is not full: whether it is."""
    numbers, most, patch = cast.numbers, cast.limits[_Limit.REQUESTS], cast.numbers[_Cast.FOUND]
    path = _path(items, patch)
    if path != _NEVER and cast.limits[_Limit.AHEAD]:
        if numbers[_Cast.REMOTE_FOUND + path] - numbers[_Cast.REMOTE_READ + path] == cast.limits[_Limit.AHEAD]:
            return False
        numbers[_Cast.FOUND] += 1
        numbers[_Cast.REMOTE_FOUND + path] += 1
        _make_ready(cast, patch)
        return True
    if path != _NEVER and cast.limits[_Limit.BEFORE_STORE]:
        path, most = THROUGH_STORE, cast.limits[_Limit.BEFORE_STORE]
    if most == (numbers[_Cast.OWN] if path == _NEVER
                else numbers[_Cast.REMOTE_FOUND + path] - numbers[_Cast.REMOTE_SENT + path]):
        return False
    numbers[_Cast.FOUND] += 1
    if path == _NEVER:
        numbers[_Cast.OWN] += 1
        _make_ready(cast, patch)
    else:
        cast.remote[numbers[_Cast.REMOTE_FOUND + path], path] = patch
        numbers[_Cast.REMOTE_FOUND + path] += 1
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
    cast.ready[cast.numbers[_Cast.AVAILABLE]] = patch
    cast.numbers[_Cast.AVAILABLE] += 1


@compiled
def _read(cast, items, time):
    """The vertices of the next patch are read, one in each cycle."""
    numbers, limits = cast.numbers, cast.limits
    if (numbers[_Cast.READING] or numbers[_Cast.READ] == numbers[_Cast.AVAILABLE]
            or numbers[_Cast.OFFERED] - numbers[_Cast.ENTERED] == limits[_Limit.WAITING]):
        return
    path = _path(items, cast.ready[numbers[_Cast.READ]])
    if path == _NEVER:
        numbers[_Cast.OWN] -= 1
    else:
        numbers[_Cast.REMOTE_READ + path] += 1
        if limits[_Limit.BEFORE_STORE] and path != THROUGH_STORE:
            numbers[_Cast.REMOTE_READ + THROUGH_STORE] += 1
    numbers[_Cast.READ] += 1
    numbers[_Cast.READING] = 1
    push(cast.heap, time + limits[_Limit.VERTICES], _Event.GEOMETRY, cast.numbers[_Cast.SELF])
    _wake_filter(cast, time)


@compiled
def _wake_filter(cast, time):
    """The patch filter may have waited for a free entry behind it."""
    numbers = cast.numbers
    if not numbers[_Cast.FILTERING] and numbers[_Cast.ENTRIES_TAKEN] < numbers[_Cast.ENTRIES_LEFT]:
        numbers[_Cast.FILTERING] = 1
        push(cast.heap, time, _Event.FILTER, numbers[_Cast.SELF])


@compiled
def _enter(cast, items, time):
    """Patches that wait enter setup while slots are free."""
    numbers, limits = cast.numbers, cast.limits
    while numbers[_Cast.ENTERED] < numbers[_Cast.OFFERED] and numbers[_Cast.SLOTS] < limits[_Limit.ALL_SLOTS]:
        patch, place = cast.ready[numbers[_Cast.ENTERED]], numbers[_Cast.ENTERED]
        # The vertices of a patch that has not waited have entered while they were read.
        waited = numbers[_Cast.OFFERED] - place > 1 or numbers[_Cast.OFFER_TIME] < time
        last_vertex = time + limits[_Limit.VERTICES] if waited else time
        numbers[_Cast.ENTERED] += 1
        numbers[_Cast.SLOTS] += 1
        numbers[_Cast.READY] = max(last_vertex + limits[_Limit.SETUP], numbers[_Cast.READY] + limits[_Limit.VERTICES])
        numbers[_Cast.WALKED] = max(numbers[_Cast.READY], numbers[_Cast.WALKED]) + items.tests[patch]
        last_ray = numbers[_Cast.WALKED] + limits[_Limit.WALK]
        push(cast.heap, last_ray, _Event.FREE, cast.numbers[_Cast.SELF])
        cast.ends[place] = last_ray + limits[_Limit.PIPELINE]
        push(cast.heap, cast.ends[place], _Event.DONE, cast.numbers[_Cast.SELF])


@compiled
def _end_stages(cast, items, time):
    """All closed stages are over when no cell and no patch is in flight."""
    numbers, limits = cast.numbers, cast.limits
    cell = numbers[_Cast.CELLS_LEFT]
    if (numbers[_Cast.LISTING] != _Lists.IDLE or numbers[_Cast.CELLS_TAKEN] != cell
            or numbers[_Cast.ENTRIES_TAKEN] != numbers[_Cast.ENTRIES_LEFT]
            or numbers[_Cast.DONE_COUNT] != numbers[_Cast.FOUND]
            or (cell < len(items.time) and items.time[cell] + numbers[_Cast.SHIFT] - limits[_Limit.MEMORY] <= time)):
        return
    numbers[_Cast.LAST] = time
    if numbers[_Cast.CLOSED] > numbers[_Cast.OVER] and _must_wait(cast):
        numbers[_Cast.PERMITTED] = time + limits[_Limit.OVER]
    numbers[_Cast.OVER] = numbers[_Cast.CLOSED]
