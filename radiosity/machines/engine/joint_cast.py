"""Joint cast: clusters that cast sections at the same time and request patches from each other over the network.

Each cluster replays the trace of its section (`radiosity.machines.engine.section_trace`). Requests and replies have a
network each, simulated flit by flit (`radiosity.machines.engine.packet_network`). Patches that no cluster holds come
over the bus (`radiosity.machines.engine.bus_path`). A patch store may be in front of both
(`radiosity.machines.engine.store_path`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError
from golden.engine.config import Memsys
from golden.engine.memsys.patches.patch_store import PatchStore
from golden.engine.noc.routing import Routing
from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import EventHeap, event_heap, next_time, pop, push
from radiosity.machines.common.timing_numbers import PositiveNumbers
from radiosity.machines.engine.bus_path import (
    BusPath,
    BusTiming,
    bus_cycle,
    bus_path,
    bus_waits,
    fetched,
    request_on_bus,
)
from radiosity.machines.engine.cluster_cast import (
    KEPT,
    NO_CLUSTER,
    ON_BUS,
    OVER_NETWORK,
    THROUGH_STORE,
    ClusterCast,
    StageItems,
    add_stage,
    apply_event,
    arrive,
    begin_cast,
    clock,
    fetch,
    free,
    last_end,
    next_begin,
    request_remote,
)
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.packet_network import (
    Count,
    Packet,
    PacketNetwork,
    network_cycle,
    packet_network,
    send,
)
from radiosity.machines.engine.section_trace import CastTimes, SectionTrace
from radiosity.machines.engine.store_path import StoreTiming, ask_store

__all__ = ["JointCast", "JointTiming", "joint_cast"]

# The kinds of event that a patch of another cluster arrives, whose subject is its packet; one over the bus, whose
# subject is a cluster; and that a lookup in the store of a cluster ends. Those of clusters are lower.
_Event = columns("_Event", "ARRIVES FETCHED LOOKED_UP", range(64, 67))
_NEVER = -1
# Events of a cluster that can wait at the same time.
_EACH = 512
# Of a cluster: stages that have begun, all of them, when the next one is scheduled to begin, when the cluster can serve
# the next request of another one, the patch that is looked up in its store, when the last one left a frame, patches
# that have been looked up, and those that have left the store in the order of their requests.
_Cluster = columns("_Cluster", "BEGUN STAGES SCHEDULED SERVED LOOKUP LEFT REQUESTED DELIVERED")
# Columns of the first elements of a cluster in the arrays of patches, stages, cells and entries of lists.
_First = columns("_First", "PATCH STAGE CELL ENTRY")
# Of machines whose clusters hold all patches.
_NO_STORE = StoreTiming(lookup=1, kept=1, passed=1, stored=1, vertices=1, waiting=1, requests=1)
_NO_BUS = BusTiming(request=1, hit=1, fetch=1, next_fetch=1, words=1, beats=1, outstanding=1, fetches=1, requests=1)
# Numbers of `JointTiming`, of `StoreTiming`, and others behind them.
_Latency = columns("_Latency", "REQUEST SERVE PORT REPLY REQUEST_FLITS REPLY_FLITS OUTSTANDING STORE_LOOKUP STORE_KEPT "
                   "STORE_PASSED STORE_STORED STORE_VERTICES STORE_REQUESTS HAS_STORE IN_ORDER NEAR TRAVERSED "
                   "GENERATOR")


@dataclass(frozen=True, kw_only=True)
class JointTiming(PositiveNumbers):
    """Numbers of the path to patches of other clusters, in cycles unless stated otherwise.

    `radiosity.machines.engine.job_latencies.joint_timing` takes them from the components of a configuration.

    Parameters
    ----------
    request
        From the cycle in which an own patch would be read to that in which the request for it enters the network.
    serve
        From a request that has left the network to its reply, which enters the network.
    port
        For which a request occupies the port of the cluster that serves it.
    reply
        From a reply that has left the network to the cycle in which the patch can be read like an own one.
    request_flits, reply_flits
        Flits of a request and of a reply.
    outstanding
        Patches that a cluster may have requested and not read, at most.

    Raises
    ------
    TypeError, ValueError
        See `PositiveNumbers`.
    """

    request: int
    serve: int
    port: int
    reply: int
    request_flits: int
    reply_flits: int
    outstanding: int


@dataclass(frozen=True, kw_only=True, eq=False)
class JointCast:
    """What clusters have done that cast together.

    Parameters
    ----------
    times
        The times of each cluster.
    owner
        Of each cluster P int64: the cluster that held each patch, in the order of discovery; -1 if this one did,
        `NO_CLUSTER` if none did, `KEPT` if the patch store had a copy.
    deferred
        C int64: requests of each cluster that waited in its patch store for a fetch.
    reads
        Patches read from main memory.
    """

    times: tuple[CastTimes, ...]
    owner: tuple[np.ndarray, ...]
    deferred: np.ndarray
    reads: int


class _Machine(NamedTuple):
    """Clusters in flat arrays: elements of cluster k begin at ``first[k]``; networks; packets that are free.

    The early heap has the patches that leave stores: the kind of an event is the cluster, its subject the patch.

    Cells have one offset more and stages one first cell more for each cluster: its numbers are moved by k.
    """

    early: EventHeap
    heap: EventHeap
    late: EventHeap
    requests: PacketNetwork
    replies: PacketNetwork
    bus: BusPath
    limits: np.ndarray
    latency: np.ndarray
    first: np.ndarray
    clusters: np.ndarray
    numbers: np.ndarray
    ends: np.ndarray
    ready: np.ndarray
    remote: np.ndarray
    closes: np.ndarray
    ahead: np.ndarray
    begins: np.ndarray
    time: np.ndarray
    offset: np.ndarray
    entries: np.ndarray
    is_new: np.ndarray
    tests: np.ndarray
    owner: np.ndarray
    patch: np.ndarray
    is_stored: np.ndarray
    has_come: np.ndarray
    taken: np.ndarray
    cycles: np.ndarray
    searches: np.ndarray
    first_cell: np.ndarray
    requested: np.ndarray
    unused: np.ndarray
    count: np.ndarray


def joint_cast(traces: Sequence[SectionTrace], home: np.ndarray, timing: ClusterTiming, joint: JointTiming, *,
               routing: Routing, buffer_flits: int, arbitration: str, router_cycles: int, slots: int,
               run_ahead: int, bus: BusTiming | None = None, memsys: Memsys | None = None,
               kept: Sequence[int] = (), store: StoreTiming | None = None,
               stores: Sequence[PatchStore] = (), in_order: bool = False) -> JointCast:
    """Sections that clusters cast from the same cycle on.

    Parameters
    ----------
    traces
        The section of each cluster, which is the node of that number.
    home
        N int64: the cluster that holds each patch, -1 if none does; or C x N, as each cluster knows it.
    timing, joint
        Latencies and capacities.
    routing, buffer_flits, arbitration, router_cycles
        Of both networks, see `packet_network`.
    slots, run_ahead
        ``icu.slots`` and ``ctu.run_ahead``.
    bus, memsys, kept
        The path to patches that no cluster holds, see `radiosity.machines.engine.bus_path.bus_path`. Default: there is
        none.
    store, stores
        The path through the patch store of each cluster, and these, as the casts before have left them; they change.
        Default: there are none.
    in_order
        Patches leave a store in the order of their requests: one that is absent blocks those behind it. Default: each
        leaves when it is there.

    Raises
    ------
    InputError
        A patch is held by no cluster, and there is no bus.
    """
    count, home = len(traces), np.asarray(home, dtype=np.int64)
    homes = np.broadcast_to(home, (count, home.shape[-1]))
    if bus is None and any((known[trace.patch] < 0).any() for known, trace in zip(homes, traces, strict=True)):
        raise InputError("machines: Patches of a joint cast without a bus must be held by clusters")
    begins = [timing.begin + trace.listing for trace in traces]
    casts = [begin_cast(replace(timing, begin=begins[number]), patches=len(trace.tests), barriers=trace.is_barrier,
                        slots=slots, run_ahead=run_ahead, number=number, before_store=store.waiting if store else 0)
             for number, trace in enumerate(traces)]
    owner, is_stored = [], []
    for number, trace in enumerate(traces):
        held = homes[number, trace.patch]
        held = np.select([held == number, held < 0], [-1, NO_CLUSTER], held)
        held, keeps = ask_store(stores[number], trace.patch, held) if store else (held, np.zeros(len(held), dtype=bool))
        owner.append(held)
        is_stored.append(keeps)
    lengths = np.array([[len(trace.tests), len(trace.cycles), len(trace.offset), len(trace.is_new)]
                        for trace in traces])
    first = np.concatenate([np.zeros((1, 4), dtype=np.int64), lengths.cumsum(axis=0)])

    def joined(arrays, dtype=np.int64):
        return np.concatenate([np.asarray(array, dtype=dtype) for array in arrays])

    clusters = np.zeros((count, len(_Cluster)), dtype=np.int64)
    clusters[:, _Cluster.STAGES] = lengths[:, _First.STAGE]
    clusters[:, [_Cluster.SCHEDULED, _Cluster.LOOKUP]] = _NEVER
    rows = count * joint.outstanding
    networks = [packet_network(routing, packets=rows, buffer_flits=buffer_flits, arbitration=arbitration,
                               router_cycles=router_cycles) for _ in range(2)]
    times = [getattr(store or _NO_STORE, name.removeprefix("STORE_").lower()) if name.startswith("STORE_")
             else getattr(joint, name.lower()) for name in _Latency._fields[:_Latency.HAS_STORE]]
    machine = _Machine(
        early=event_heap(_EACH * count), heap=event_heap(_EACH * count), late=event_heap(_EACH * count),
        requests=networks[0], replies=networks[1],
        bus=bus_path(bus or _NO_BUS, memsys or Memsys(), clusters=count, kept=kept), limits=casts[0].limits,
        latency=np.array([*times, store is not None, in_order, timing.memory, timing.memory + timing.traversal,
                          timing.generator], dtype=np.int64),
        first=first, clusters=clusters, numbers=np.stack([cast.numbers for cast in casts]),
        **{name: joined(getattr(cast, name) for cast in casts) for name in (
            "ends", "ready", "remote", "closes", "ahead")},
        begins=np.zeros(first[-1, _First.STAGE], dtype=np.int64), time=np.zeros(first[-1, _First.CELL], dtype=np.int64),
        **{name: joined(getattr(trace, name) for trace in traces) for name in (
            "offset", "entries", "patch", "tests", "cycles", "searches", "first_cell")},
        is_new=joined((trace.is_new for trace in traces), bool),
        taken=np.zeros(count, dtype=np.int64),
        owner=joined(owner), is_stored=joined(is_stored, bool), has_come=np.zeros(first[-1, _First.PATCH], dtype=bool),
        requested=np.zeros(rows, dtype=np.int64),
        unused=np.arange(rows)[::-1].copy(), count=np.array([rows], dtype=np.int64))
    for number in range(count):
        push(machine.late, begins[number], 0, number)
        clusters[number, _Cluster.SCHEDULED] = begins[number]
    _run(machine)
    times = []
    for number, trace in enumerate(traces):
        cast, (patch, stage, _, _) = _cast(machine, number), first[number]
        times.append(CastTimes(
            begins=machine.begins[stage:stage + len(trace.cycles)], ends=machine.ends[patch:patch + len(trace.tests)],
            free=free(cast), cycles=int(last_end(cast)) + timing.over + timing.end))
    return JointCast(times=tuple(times), owner=tuple(owner), reads=fetched(machine.bus),
                     deferred=np.array([np.count_nonzero(each) for each in is_stored]))


@compiled
def _cast(machine, number):
    """A cluster's part of the state."""
    first, end = machine.first[number], machine.first[number + 1]
    patch, after, stage, last = first[_First.PATCH], end[_First.PATCH], first[_First.STAGE], end[_First.STAGE]
    return ClusterCast(machine.heap, machine.numbers[number], machine.limits, machine.ends[patch:after],
                       machine.closes[stage:last], machine.ahead[stage:last], machine.ready[patch:after],
                       machine.remote[patch:after])


@compiled
def _items(machine, number):
    """The items of the stages of a cluster that have begun."""
    first, end, begun = machine.first[number], machine.first[number + 1], machine.clusters[number, _Cluster.BEGUN]
    cell = first[_First.CELL]
    known = machine.first_cell[first[_First.STAGE] + number + begun]
    return StageItems(machine.time[cell:cell + known], machine.entries[cell + number:cell + number + known + 1],
                      machine.is_new[first[_First.ENTRY]:end[_First.ENTRY]],
                      machine.tests[first[_First.PATCH]:end[_First.PATCH]],
                      machine.owner[first[_First.PATCH]:end[_First.PATCH]])


@compiled
def _run(machine):
    """All events. In a cycle: patches that leave stores, events of clusters, then the networks, then begins of stages
    and what follows at once.
    """
    early, heap, late, cycled = machine.early, machine.heap, machine.late, _NEVER
    while True:
        time = next_time(heap)
        for other in (early, late):
            if next_time(other) != _NEVER and (time == _NEVER or next_time(other) < time):
                time = next_time(other)
        unarrived = machine.requests.counts[Count.UNARRIVED] + machine.replies.counts[Count.UNARRIVED]
        is_active = unarrived > 0 or bus_waits(machine.bus)
        if is_active and cycled != _NEVER and (time == _NEVER or cycled + 1 < time):
            time = cycled + 1
        if time == _NEVER:
            return
        while next_time(early) == time:
            _, number, patch = pop(early)
            _deliver(machine, number, time, patch)
            _update(machine, number, time)
        while next_time(heap) == time:
            _, kind, subject = pop(heap)
            number = subject
            if kind == _Event.ARRIVES:
                number = _accept(machine, subject, time)
            elif kind == _Event.FETCHED:
                # Patches of a cluster arrive over the bus in the order of its requests.
                _return(machine, number, time, _cast(machine, number).remote[machine.taken[number], ON_BUS])
                machine.taken[number] += 1
            elif kind == _Event.LOOKED_UP:
                _look_up(machine, number, time)
            else:
                apply_event(_cast(machine, number), _items(machine, number), time, kind)
            _update(machine, number, time)
        if time > cycled:
            _cycle(machine, time)
            cycled = time
        while next_time(late) == time:
            _, _, number = pop(late)
            _begin(machine, number, time)


@compiled
def _begin(machine, number, time):
    """The next stage of a cluster begins, if nothing has happened since that was scheduled."""
    state, first = machine.clusters[number], machine.first[number]
    if state[_Cluster.SCHEDULED] != time:
        return
    state[_Cluster.SCHEDULED] = _NEVER
    stage, cast = first[_First.STAGE] + state[_Cluster.BEGUN], _cast(machine, number)
    begin = next_begin(cast, _permission(machine, number))
    if begin == _NEVER or begin > time:
        _update(machine, number, time)
        return
    latency = machine.latency[_Latency.TRAVERSED] if state[_Cluster.BEGUN] else machine.latency[_Latency.NEAR]
    start = clock(cast, time) + latency
    for cell in range(machine.first_cell[stage + number], machine.first_cell[stage + number + 1]):
        machine.time[first[_First.CELL] + cell] = start + machine.offset[first[_First.CELL] + cell]
    is_near = state[_Cluster.BEGUN] == 0
    machine.begins[stage] = time
    state[_Cluster.BEGUN] += 1
    add_stage(cast, _items(machine, number), time, machine.cycles[stage], is_near)
    _update(machine, number, time)


@compiled
def _permission(machine, number):
    """Cycles from the permission of the next stage of a cluster to its begin."""
    begun = machine.clusters[number, _Cluster.BEGUN]
    if begun == 0:
        return 0
    return machine.latency[_Latency.GENERATOR] + machine.searches[machine.first[number, _First.STAGE] + begun]


@compiled
def _update(machine, number, time):
    """What may follow an event of a cluster: requests to other clusters, and the begin of a stage."""
    state, cast, latency = machine.clusters[number], _cast(machine, number), machine.latency
    items = _items(machine, number)
    if latency[_Latency.HAS_STORE] and state[_Cluster.LOOKUP] == _NEVER:
        state[_Cluster.LOOKUP] = request_remote(cast, items, time, THROUGH_STORE, latency[_Latency.STORE_REQUESTS])
        if state[_Cluster.LOOKUP] != _NEVER:
            state[_Cluster.REQUESTED] += 1
            push(machine.heap, time + latency[_Latency.STORE_LOOKUP], _Event.LOOKED_UP, number)
    while True:
        patch = request_remote(cast, items, time, OVER_NETWORK, latency[_Latency.OUTSTANDING])
        if patch == _NEVER:
            break
        machine.count[0] -= 1
        packet = machine.unused[machine.count[0]]
        machine.requested[packet] = patch
        _send(machine.requests, packet, number, items.owner[patch], latency[_Latency.REQUEST_FLITS],
              time + latency[_Latency.REQUEST])
    while True:
        patch = request_remote(cast, items, time, ON_BUS, machine.bus.waiting.shape[1])
        if patch == _NEVER:
            break
        request_on_bus(machine.bus, time, number, machine.patch[machine.first[number, _First.PATCH] + patch])
    if state[_Cluster.BEGUN] < state[_Cluster.STAGES]:
        begin = next_begin(cast, _permission(machine, number))
        if begin != _NEVER:
            begin = max(begin, time)
            if state[_Cluster.SCHEDULED] != begin:
                state[_Cluster.SCHEDULED] = begin
                push(machine.late, begin, 0, number)


@compiled
def _send(network, packet, source, destination, flits, made):
    given = network.packets[packet]
    given[Packet.SOURCE], given[Packet.DESTINATION], given[Packet.LENGTH] = source, destination, flits
    given[Packet.MADE] = made
    send(network, packet)


@compiled
def _cycle(machine, time):
    """A cycle of networks and bus: requests that leave theirs are served in turn, replies reach their clusters."""
    requests, replies, latency = machine.requests, machine.replies, machine.latency
    if requests.counts[Count.UNARRIVED]:
        network_cycle(requests, time)
        for index in range(requests.counts[Count.TAKEN_NOW]):
            packet = requests.taken[index]
            server = requests.packets[packet, Packet.DESTINATION]
            begin = max(time + latency[_Latency.SERVE], machine.clusters[server, _Cluster.SERVED])
            machine.clusters[server, _Cluster.SERVED] = begin + latency[_Latency.PORT]
            _send(replies, packet, server, requests.packets[packet, Packet.SOURCE], latency[_Latency.REPLY_FLITS],
                  begin)
    if replies.counts[Count.UNARRIVED]:
        network_cycle(replies, time)
        for index in range(replies.counts[Count.TAKEN_NOW]):
            push(machine.heap, time + latency[_Latency.REPLY], _Event.ARRIVES, replies.taken[index])
    if bus_waits(machine.bus):
        number, ready = bus_cycle(machine.bus, time)
        if number != _NEVER:
            push(machine.heap, ready, _Event.FETCHED, number)


@compiled
def _accept(machine, packet, time):
    """A patch arrives: at which cluster."""
    number = machine.requests.packets[packet, Packet.SOURCE]
    _return(machine, number, time, machine.requested[packet])
    machine.unused[machine.count[0]] = packet
    machine.count[0] += 1
    return number


@compiled
def _return(machine, number, time, patch):
    """A patch has come from where it is: to the cluster, or to its patch store."""
    latency = machine.latency
    if not latency[_Latency.HAS_STORE]:
        arrive(_cast(machine, number), _items(machine, number), time, patch)
    elif machine.is_stored[machine.first[number, _First.PATCH] + patch]:
        _leave_frame(machine, number, time + latency[_Latency.STORE_STORED], patch)
    else:
        push(machine.early, time + latency[_Latency.STORE_PASSED], number, patch)


@compiled
def _deliver(machine, number, time, patch):
    """A patch can leave the store of a cluster: it does, or waits for those that were requested before it."""
    state, cast, items = machine.clusters[number], _cast(machine, number), _items(machine, number)
    if not machine.latency[_Latency.IN_ORDER]:
        arrive(cast, items, time, patch)
        return
    first = machine.first[number, _First.PATCH]
    machine.has_come[first + patch] = True
    while state[_Cluster.DELIVERED] < state[_Cluster.REQUESTED]:
        following = cast.remote[state[_Cluster.DELIVERED], THROUGH_STORE]
        if not machine.has_come[first + following]:
            return
        state[_Cluster.DELIVERED] += 1
        arrive(cast, items, time, following)


@compiled
def _look_up(machine, number, time):
    """A lookup in a patch store ends: the patch leaves its frame, or is fetched."""
    state, latency = machine.clusters[number], machine.latency
    items, patch = _items(machine, number), state[_Cluster.LOOKUP]
    state[_Cluster.LOOKUP] = _NEVER
    if items.owner[patch] == KEPT:
        _leave_frame(machine, number, time - latency[_Latency.STORE_LOOKUP] + latency[_Latency.STORE_KEPT], patch)
    else:
        fetch(_cast(machine, number), items, patch)


@compiled
def _leave_frame(machine, number, time, patch):
    """A patch leaves its frame, behind those before it."""
    state = machine.clusters[number]
    state[_Cluster.LEFT] = max(time, state[_Cluster.LEFT] + machine.latency[_Latency.STORE_VERTICES])
    push(machine.early, state[_Cluster.LEFT], number, patch)
