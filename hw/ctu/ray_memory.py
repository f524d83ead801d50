"""Ray memory of cell traversal: each grid ray leaves once, and one ray of a slot at a time."""

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.wiring import In, Out

from hw.lib.checks import claim, claim_steps, count_entries, count_steps
from hw.lib.fork import Fork
from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory
from hw.lib.validate import check_integer
from hw.memsys.patches.istructure import IStructure

__all__ = ["RayMemory"]

# Rays that have left and are not accepted yet, or may leave.
LEAVING = 16


class _Kind(enum.Enum, shape=2):
    REQUEST = 0
    RETRY = 1
    RETURN = 2
    CLEAR = 3


class RayMemory(wiring.Component):
    """A request for the version that its slot has is dropped: this ray has left. Otherwise, if the slot's ray is
    present, it leaves and the slot takes the request's version; if it is absent, the request is deferred.

    ::

        i ----------+- rows: version, presence -+- leaves --- o
        i_return ---+          |                '- dropped -- o_passed
                    |          | deferred reads, returns, departures
                    '----- IStructure

    Deferral is an I-structure with a location for each slot. A departure renews the slot's location, a return writes
    it, and a deferred request reads it: the read is answered when the ray is back. Then the request is tried again, in
    the order of the chain: the first one for another version leaves, and those behind it are deferred again. Until then
    the slot is held for them: a request that comes meanwhile is deferred too, behind them.

    First come, first served: the rays of a slot leave in the order of its requests. A deferred request has a ticket,
    and the row has the ticket to serve next; a request with another one is deferred again. The chains alone do not
    keep the order: a ray may come back while the last requests of the chain are still to be tried, and the first ones
    wait again.

    Several rays may share a slot, each is a version of it. A ray that left before another ray of its slot leaves again
    if it is requested again: that costs cycles, and nothing is lost.

    Parameters
    ----------
    slots
        Grid rays that the memory distinguishes, at least 1.
    version_bits
        Bits of a version, which is at least 1.
    deferred
        Requests that are deferred or being decided, at most; at least 1.
    generation_bits
        Bits of the generation tags that make all slots present, of version 0.
    tag
        Shape of a request's sideband.

    Members
    -------
    i_start : In, stream without payload
        Begins a frustum: all slots are present, of version 0. Accepted when no request is deferred; the sender
        guarantees that no ray is absent.
    i : In, stream of ``slot``, ``version``, ``tag``
        Requests.
    i_return : In, stream of range(slots)
        The slot of a ray that is back. Always ready.
    o : Out, stream of ``slot``, ``version``, ``tag``
        Rays that leave, with the version and the tag of the request.
    o_passed : Out, stream of tags
        The tag of a request that is dropped. Always ready.
    waiting : Out(range(deferred + 1))
        Deferred requests.

    Timing
    ------
    Latency: ``7`` cycles from ``i`` to ``o``, ``21`` from ``i_return`` to the ray that leaves again. One request or
    return per cycle: returns before deferred requests, and these before new ones. Requests stall with ``o`` and while
    ``deferred`` of them are deferred or being decided; returns never stall.

    Raises
    ------
    TypeError, ValueError
        A size of the wrong type or out of range.

    Golden counterpart: `golden.engine.ctu.ray_memory.RayMemory`, which also accepts requests that need not wait while
    it is full. Source: Shen 1993, Fig. 5.10 and section 5.3.4.4.
    """

    def __init__(self, *, slots: int, version_bits: int, deferred: int, generation_bits: int, tag):
        for name, value in (("Slots", slots), ("Version bits", version_bits), ("Deferred", deferred),
                            ("Generation bits", generation_bits)):
            check_integer(name, value, minimum=1)
        self._slots, self._version_bits, self._deferred = slots, version_bits, deferred
        self._generation_bits = generation_bits
        request = self._request = StructLayout({"slot": range(slots), "version": version_bits, "tag": tag})
        # A deferred request. Tickets of those that wait for a slot differ.
        self._ticket = deferred.bit_length()
        self._waiter = StructLayout({"ticket": self._ticket, "request": request})
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(request)),
            "i_return": In(stream.Signature(range(slots), always_ready=True)), "o": Out(stream.Signature(request)),
            "o_passed": Out(stream.Signature(tag, always_ready=True)), "waiting": Out(range(deferred + 1))})
        self.latency = 7

    def elaborate(self, platform):
        m = Module()
        m.submodules.generations = generations = Generations(bits=self._generation_bits, depth=self._slots)
        # ``held``: the ray is back for the requests that wait, which are ``waiters``; ``turn``: the first one's ticket.
        ticket = self._ticket
        row = StructLayout({"generation": self._generation_bits, "version": self._version_bits, "away": 1, "held": 1,
                            "waiters": range(self._deferred + 1), "turn": ticket})
        access = StructLayout({"kind": _Kind, "ticket": ticket, "version": self._version_bits})

        def decide(old, access):
            """The state of a slot in this frustum, and whether an access leaves or is deferred."""
            now, retries = old.generation == generations.generation, access.kind == _Kind.RETRY
            state = {"version": Mux(now, old.version, 0), "away": now & old.away, "held": now & old.held,
                     "waiters": Mux(now, old.waiters, 0), "turn": Mux(now, old.turn, 0)}
            other, served = access.version != state["version"], state["held"] & (access.ticket == state["turn"])
            leaves = other & Mux(retries, served, (access.kind == _Kind.REQUEST) & ~state["away"])
            defers = Mux(retries, ~served, (access.kind == _Kind.REQUEST) & other & state["away"])
            return state, leaves, defers

        def change(_, old, access):
            state, leaves, defers = decide(old, access)
            returns, clears, retries = (access.kind == kind for kind in (_Kind.RETURN, _Kind.CLEAR, _Kind.RETRY))
            ends = retries & ~defers
            waiters = Value.cast(state["waiters"] + (defers & ~retries) - ends)[:len(old.waiters)]
            held = Mux(returns, state["waiters"] != 0, state["held"] & ~leaves & ~(ends & (waiters == 0)))
            new = {"generation": Mux(clears, 0, generations.generation),
                   "version": Mux(leaves, access.version, state["version"]),
                   "away": leaves | Mux(returns | ends, held, state["away"]), "held": held, "waiters": waiters,
                   "turn": (state["turn"] + ends)[:ticket]}
            return View(row, Cat(new.values())), returns | clears | leaves | defers | ends

        m.submodules.rows = rows = UpdateMemory(
            row, depth=self._slots, operand=access, change=change,
            tag=StructLayout({"kind": _Kind, **self._waiter.members}))
        # What an access comes to.
        made, done = Signal.like(rows.o.payload.tag, reset_less=True), Signal()
        came = rows.o.payload
        state, leaves_now, defers_now = decide(
            came.old, View(access, Cat(came.tag.kind, came.tag.ticket, came.tag.request.version)))
        leaves, defers = Signal(reset_less=True), Signal(reset_less=True)
        m.d.sync += [done.eq(rows.o.valid), made.eq(came.tag), leaves.eq(leaves_now), defers.eq(defers_now)]
        with m.If(came.tag.kind == _Kind.REQUEST):
            m.d.sync += made.ticket.eq(state["turn"] + state["waiters"])
        requested, retried, returned = (Signal(name=name) for name in ("requested", "retried", "returned"))
        m.d.comb += [flag.eq(done & (made.kind == kind)) for flag, kind in (
            (requested, _Kind.REQUEST), (retried, _Kind.RETRY), (returned, _Kind.RETURN))]
        decided, departs, resolved = requested | retried, Signal(), Signal()
        m.submodules.leaving = leaving = Queue(self._request, depth=LEAVING)
        wiring.connect(m, leaving.o, wiring.flipped(self.o))
        m.d.comb += [
            departs.eq(done & leaves), resolved.eq(decided & ~defers),
            leaving.i.valid.eq(departs), leaving.i.payload.eq(made.request),
            self.o_passed.valid.eq(resolved & ~leaves), self.o_passed.payload.eq(made.request.tag)]

        retry, restart = self._add_deferral(m, made, requested=requested, retried=retried, returned=returned,
                                            departs=departs, defers=defers)
        enters = self._add_accesses(m, rows.i, retry, generations, resolved=resolved, stays=decided & ~leaves)
        count_entries(self.waiting)
        count_steps(m, self.waiting, up=requested & defers, down=retried & ~defers, most=self._deferred)
        claim(m, ~leaving.i.valid | leaving.i.ready, "a departure has an entry")

        # A frustum begins when no access is in flight and no request is deferred.
        in_flight, quiet = Signal(self.latency - 1), Signal()
        m.d.sync += in_flight.eq((in_flight << 1) | enters)
        m.submodules.starts = starts = Fork(0, count=2)
        m.d.comb += [
            quiet.eq(~in_flight.any() & ~self.i_return.valid & (self.waiting == 0)),
            starts.i.valid.eq(self.i_start.valid & quiet), self.i_start.ready.eq(starts.i.ready & quiet)]
        for output, start in zip(starts.o, (generations.i_start, restart), strict=True):
            m.d.comb += [start.valid.eq(output.valid), output.ready.eq(start.ready)]
        return m

    def _add_deferral(self, m, made, *, requested, retried, returned, departs, defers):
        """The I-structure: its answers are deferred requests that are tried again; and its start."""
        m.submodules.absent = absent = IStructure(
            0, depth=self._slots, version_bits=self._generation_bits, deferred=self._deferred, tag=self._waiter,
            renews=True)
        claim(m, ~absent.o_refused.valid, "what is written was absent")
        waiter = Cat(made.ticket, made.request)
        # None of them is ever full: at most ``deferred`` requests are in flight.
        first, again = (Queue(self._waiter, depth=self._deferred) for _ in range(2))
        m.submodules.first, m.submodules.again = first, again
        # First come, first served: a request that is deferred for the first time is read when those that waited longer
        # are in chains again. ``trying``: requests that are decided again or read again.
        read, trying, may_read = absent.i_read, Signal(range(self._deferred + 1)), Signal()
        tries = absent.o_read.valid & absent.o_read.ready
        claim_steps(m, trying, up=tries, down=(retried & ~defers) + (again.o.valid & again.o.ready),
                    most=self._deferred)
        for name, queue in ("first", first), ("again", again):
            claim(m, ~queue.i.valid | queue.i.ready, f"a request has an entry of {name}")
        m.d.sync += trying.eq(trying + tries - (retried & ~defers) - (again.o.valid & again.o.ready))
        m.d.comb += [
            first.i.valid.eq(requested & defers), first.i.payload.eq(waiter),
            again.i.valid.eq(retried & defers), again.i.payload.eq(waiter),
            # Only when it is accepted, so that no offer is withdrawn.
            may_read.eq((trying == 0) & ~absent.releases & read.ready),
            read.valid.eq(again.o.valid | (first.o.valid & may_read)), again.o.ready.eq(read.ready),
            first.o.ready.eq(may_read & ~again.o.valid),
            read.payload.tag.eq(Mux(again.o.valid, again.o.payload.as_value(), first.o.payload.as_value())),
            read.payload.address.eq(Mux(again.o.valid, again.o.payload.request.slot, first.o.payload.request.slot)),
            # Both are always ready: no version ends while accesses are in flight.
            absent.i_renew.valid.eq(departs), absent.i_renew.payload.eq(made.request.slot),
            absent.i_write.valid.eq(returned), absent.i_write.payload.address.eq(made.request.slot)]
        return absent.o_read, absent.i_start

    def _add_accesses(self, m, rows, retry, generations, *, resolved, stays):
        """Returns first, then deferred requests, then new ones. A request has a credit for the queue of departures."""
        credits, held = Signal(range(LEAVING + 1), init=LEAVING), Signal(range(self._deferred + 1))
        begun, accepts, retries = Signal(), Signal(), Signal()
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += begun.eq(1)
        m.d.comb += [
            retry.ready.eq(~self.i_return.valid & (credits != 0)), retries.eq(retry.valid & retry.ready),
            self.i.ready.eq(begun & ~self.i_start.valid & ~self.i_return.valid & ~retry.valid & (credits != 0)
                            & (held != self._deferred)),
            accepts.eq(self.i.valid & self.i.ready)]
        leaves = self.o.valid & self.o.ready
        count_entries((LEAVING - credits) + held)
        claim_steps(m, credits, up=stays + leaves, down=accepts | retries, most=LEAVING)
        m.d.sync += credits.eq(credits - (accepts | retries) + stays + leaves)
        count_steps(m, held, up=accepts, down=resolved, most=self._deferred)

        entry, enters = Signal(rows.payload.tag.shape(), reset_less=True), Signal()
        m.d.comb += [
            rows.valid.eq(enters), rows.payload.tag.eq(entry), rows.payload.address.eq(entry.request.slot),
            *(rows.payload.operand[name].eq(entry[name]) for name in ("kind", "ticket")),
            rows.payload.operand.version.eq(entry.request.version)]
        m.d.sync += [enters.eq(self.i_return.valid | retries | accepts | generations.sweeps),
                     entry.kind.eq(_Kind.RETRY),
                     *(entry[name].eq(retry.payload.tag[name]) for name in ("ticket", "request"))]
        with m.If(accepts):
            m.d.sync += [entry.kind.eq(_Kind.REQUEST), entry.request.eq(self.i.payload)]
        for happens, kind, slot in ((self.i_return.valid, _Kind.RETURN, self.i_return.payload),
                                    (generations.sweeps, _Kind.CLEAR, generations.row)):
            with m.If(happens):
                m.d.sync += [entry.kind.eq(kind), entry.request.slot.eq(slot)]
        return accepts | retries | self.i_return.valid
