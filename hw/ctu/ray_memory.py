"""Ray memory of cell traversal: each grid ray leaves once, and one ray of a slot at a time."""

from types import SimpleNamespace

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory

__all__ = ["RayMemory"]

# Rays that have left and are not taken yet, or may leave.
ROOM = 16


class _Kind(enum.Enum, shape=2):
    REQUEST = 0
    RETURN = 1
    RETRY = 2
    CLEAR = 3


class RayMemory(wiring.Component):
    """A request for the version that the slot has is passed over: this ray has left. Else a present ray leaves and
    takes the version; for one that is away the request waits.

    Several rays may share a slot, each a version of it. One that left before another one of the slot leaves again if it
    is asked for again: that costs, and nothing is lost.

    Requests that wait for a slot are a chain, the oldest first. When the ray comes back it is held until the first of
    them that is for another version has it; those before it are passed over, the others go on waiting. A request that
    comes meanwhile goes to the end of the chain.

    Parameters
    ----------
    slots
        Places of grid rays, at least 1.
    version_bits
        Of a version, which is at least 1.
    deferred
        Requests that wait or are being looked at, at least 1.
    generation_bits
        Of the tags that make all slots present, of version 0.
    tag
        Shape of what goes along with a request.

    Members
    -------
    i_start
        Begins a frustum: all slots are present, of version 0. Taken when nothing waits; the sender sees to it that no
        ray is away. No payload.
    i
        Requests: ``slot``, ``version``, ``tag``.
    i_return
        The slot of a ray that comes back. Always ready.
    o
        Rays that leave: ``slot``, and ``version`` and ``tag`` of the request.
    o_passed
        ``tag`` of a request that is passed over. Always ready.
    waiting
        Requests that wait now.

    Timing
    ------
    Latency: ``7`` cycles from ``i`` to ``o``, ``15`` from ``i_return`` to the ray that leaves again. One request or
    return per cycle, returns first, then those that waited. Requests stall with ``o``, and while ``deferred`` of them
    wait or are being looked at; returns never stall.

    Errors
    ------
    ValueError
        A size out of range.

    Golden counterpart: `golden.ctu.ray_memory.RayMemory`, which looks at requests that need not wait when it is full
    too. Source: Shen 1993, Fig. 5.10 and section 5.3.4.4.
    """

    def __init__(self, *, slots: int, version_bits: int, deferred: int, generation_bits: int, tag):
        for name, value in (("Slots", slots), ("Version bits", version_bits), ("Deferred", deferred),
                            ("Generation bits", generation_bits)):
            if not isinstance(value, int) or value < 1:
                raise ValueError(f"{name} must be at least 1, not {value!r}")
        self._slots, self._version_bits, self._deferred = slots, version_bits, deferred
        self._generation_bits, self._tag = generation_bits, tag
        request = StructLayout({"slot": range(slots), "version": version_bits, "tag": tag})
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(request)),
            "i_return": In(stream.Signature(range(slots), always_ready=True)), "o": Out(stream.Signature(request)),
            "o_passed": Out(stream.Signature(tag, always_ready=True)), "waiting": Out(range(deferred + 1))})
        self.latency = 7

    def elaborate(self, platform):
        m = Module()
        place, version = range(self._deferred), self._version_bits
        m.submodules.generations = generations = Generations(bits=self._generation_bits, depth=self._slots)
        generation = generations.generation
        row = StructLayout({"generation": self._generation_bits, "version": version, "away": 1, "waits": 1,
                            "first": place, "last": place})
        # ``place`` is the request's; of a retry ``next`` is who waits behind it, if ``linked``.
        access = StructLayout({"kind": _Kind, "version": version, "place": place, "linked": 1, "next": place})
        carried = StructLayout({"access": access, "tag": self._tag})

        def judge(old, access):
            """What a slot is, and what an access does there."""
            requests, now = access.kind == _Kind.REQUEST, old.generation == generation
            known = Mux(now, old.version, 0)
            other, away, waits, alone = access.version != known, now & old.away, now & old.waits, old.first == old.last
            # Somebody may have come behind the last one since it was looked up: then it is tried again.
            ends = (access.kind == _Kind.RETRY) & (alone | access.linked)
            leaves, defers = other & Mux(requests, ~away, ends), requests & other & away
            return SimpleNamespace(known=known, away=away, waits=waits, alone=alone, ends=ends, leaves=leaves,
                                   defers=defers)

        def change(old, access):
            it, returns, clears = judge(old, access), access.kind == _Kind.RETURN, access.kind == _Kind.CLEAR
            waits = Mux(it.ends, ~it.alone, it.waits | it.defers)
            new = {"generation": Mux(clears, 0, generation), "version": Mux(it.leaves, access.version, it.known),
                   "away": it.leaves | Mux(returns | it.ends, waits, it.away), "waits": waits,
                   "first": Mux(it.ends, access.next, Mux(it.defers & ~it.waits, access.place, old.first)),
                   "last": Mux(it.defers, access.place, old.last)}
            return View(row, Cat(new.values())), returns | clears | it.ends | it.leaves | it.defers

        m.submodules.rows = rows = UpdateMemory(row, depth=self._slots, operand=access, tag=carried, change=change)

        # What an access has come to. A ray that is back is tried on the first request of its chain.
        tried = StructLayout({"slot": range(self._slots), "place": place})
        m.submodules.tries, m.submodules.leaving = tries, leaving = Queue(tried, depth=self._deferred), Queue(
            self.o.payload.shape(), depth=ROOM)
        made, done = Signal.like(rows.o.payload, reset_less=True), Signal()
        found = judge(rows.o.payload.old, rows.o.payload.tag.access)
        now = SimpleNamespace(**{name: Signal(name=f"now_{name}", reset_less=True)
                                 for name in ("waits", "alone", "ends", "leaves", "defers")})
        m.d.sync += [done.eq(rows.o.valid), made.eq(rows.o.payload),
                     *(flag.eq(getattr(found, name)) for name, flag in vars(now).items())]
        kind, old = made.tag.access.kind, made.old
        returned, requested, retried = (done & (kind == one) for one in (_Kind.RETURN, _Kind.REQUEST, _Kind.RETRY))
        passed_over = retried & now.ends & ~now.leaves
        m.d.comb += [
            tries.i.valid.eq((returned & now.waits) | (retried & ~now.ends) | (passed_over & ~now.alone)),
            tries.i.payload.slot.eq(made.address),
            tries.i.payload.place.eq(Mux(now.ends, made.tag.access.next, old.first)),
            leaving.i.valid.eq(done & now.leaves), leaving.i.payload.slot.eq(made.address),
            leaving.i.payload.version.eq(made.tag.access.version), leaving.i.payload.tag.eq(made.tag.tag)]
        wiring.connect(m, leaving.o, wiring.flipped(self.o))
        m.d.comb += [self.o_passed.payload.eq(made.tag.tag),
                     self.o_passed.valid.eq(((requested & ~now.defers) | (retried & now.ends)) & ~now.leaves)]

        # Places of requests: free ones, who waits in them, who waits behind whom if anybody does.
        m.submodules.free = free = Queue(place, depth=self._deferred)
        m.submodules.entries = entries = Memory(shape=StructLayout({"version": version, "tag": self._tag}),
                                                depth=self._deferred, init=[], attrs={"no_rw_check": 1})
        m.submodules.behind = behind = Memory(shape=place, depth=self._deferred, init=[],
                                              attrs={"ram_style": "distributed"})
        linked, unused, new = Signal(self._deferred), Signal(range(self._deferred + 1)), Signal(place)
        defers, ends = done & now.defers, retried & now.ends
        recycles, takes = unused == self._deferred, self.i.valid & self.i.ready
        write, link = entries.write_port(), behind.write_port()
        m.d.comb += [
            new.eq(Mux(recycles, free.o.payload, unused)), free.o.ready.eq(takes & recycles),
            free.i.valid.eq((requested & ~now.defers) | ends), free.i.payload.eq(made.tag.access.place),
            write.addr.eq(made.tag.access.place), write.data.version.eq(made.tag.access.version),
            write.data.tag.eq(made.tag.tag), write.en.eq(defers),
            link.addr.eq(old.last), link.data.eq(made.tag.access.place), link.en.eq(defers & now.waits)]
        with m.If(takes & ~recycles):
            m.d.sync += unused.eq(unused + 1)
        with m.If(defers):
            m.d.sync += linked.bit_select(made.tag.access.place, 1).eq(0)
            with m.If(now.waits):
                m.d.sync += linked.bit_select(old.last, 1).eq(1)
        m.d.sync += self.waiting.eq(self.waiting + defers - ends)

        # The next try, looked up.
        retry, retries, goes = Signal(StructLayout({"slot": range(self._slots), "carried": carried}),
                                      reset_less=True), Signal(), Signal()
        entry, next_one = entries.read_port(domain="comb"), behind.read_port(domain="comb")
        at = tries.o.payload.place
        m.d.comb += [entry.addr.eq(at), next_one.addr.eq(at), tries.o.ready.eq(goes | ~retries)]
        with m.If(tries.o.ready):
            m.d.sync += [retries.eq(tries.o.valid), retry.slot.eq(tries.o.payload.slot),
                         retry.carried.tag.eq(entry.data.tag), retry.carried.access.kind.eq(_Kind.RETRY),
                         retry.carried.access.version.eq(entry.data.version), retry.carried.access.place.eq(at),
                         retry.carried.access.next.eq(next_one.data),
                         retry.carried.access.linked.eq(linked.bit_select(at, 1))]

        # Who is next: returns, then tries, then requests. Whoever may leave has room where it leaves.
        given, comes, room, under_way = Signal.like(rows.i.payload, reset_less=True), Signal(), Signal(
            range(ROOM + 1), init=ROOM), Signal(6)
        begun, idle = Signal(), Signal()
        m.d.comb += [
            rows.i.valid.eq(comes), rows.i.payload.eq(given),
            goes.eq(retries & ~self.i_return.valid & (room != 0)),
            self.i.ready.eq(begun & ~self.i_start.valid & ~self.i_return.valid & ~retries & (room != 0)
                            & (~recycles | free.o.valid))]
        m.d.sync += [
            comes.eq(self.i_return.valid | goes | takes | generations.sweeps),
            room.eq(room - (goes | takes) + ((requested | retried) & ~now.leaves) + (self.o.valid & self.o.ready)),
            given.tag.eq(retry.carried), given.operand.eq(retry.carried.access), given.address.eq(retry.slot)]
        for happens, address, carries in (
                (takes, self.i.payload.slot, {"kind": _Kind.REQUEST, "version": self.i.payload.version, "place": new}),
                (self.i_return.valid, self.i_return.payload, {"kind": _Kind.RETURN}),
                (generations.sweeps, generations.row, {"kind": _Kind.CLEAR})):
            with m.If(happens):
                m.d.sync += given.address.eq(address)
                m.d.sync += [part[name].eq(value) for part in (given.operand, given.tag.access)
                             for name, value in carries.items()]
        with m.If(takes):
            m.d.sync += given.tag.tag.eq(self.i.payload.tag)

        # A frustum begins when no access is under way and nothing waits.
        m.d.sync += under_way.eq((under_way << 1) | (takes | self.i_return.valid | goes))
        m.d.comb += [idle.eq(~under_way.any() & ~self.i_return.valid & (self.waiting == 0)),
                     generations.i_start.valid.eq(self.i_start.valid & idle),
                     self.i_start.ready.eq(generations.i_start.ready & idle)]
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += begun.eq(1)
        return m
