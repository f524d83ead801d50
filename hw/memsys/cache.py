"""Cache: records by key, from its lines or from memory."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.credit_gate import CreditGate
from hw.lib.queue import Queue
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.lfu_placement import LfuPlacement
from hw.memsys.set_placement import SetPlacement

__all__ = ["Cache"]


class Cache(wiring.Component):
    """Requests are answered in their order: what is in a line, and what is fetched into one.

    Lines are given out at once, when a request is looked up; what they hold follows later, in the same order: a hit
    reads its line when its turn comes, a miss waits for what it has fetched and writes it. So a second request for
    what is being fetched is a hit that waits, and a line can be given away while its record is still awaited::

        i - credits - placement -+- answers, a queue -+- fill buffer: a miss - line memory -- o
                                 '- o_fetch ... i_fill -'            a hit  -'

    A fetch has a slot, with room for the whole record, before memory is asked. So fills always sink, in any order of
    the slots.

    Parameters
    ----------
    beat, beats
        Shape of a beat, and beats of a record, at least 1.
    config
        The configuration.
    lines
        A power of two.
    key, tag
        Shapes of a key, and of what goes along with a request.
    policies
        Those that are built; all by default.

    Members
    -------
    i_invalidate
        Empties all lines, counts from 0 again, and sets the `CachePolicy`; of one that is not built it takes the first
        that is. Taken when everything has been answered. Requests are taken after the first one.
    i
        ``tag`` and ``key``.
    o
        ``tag``, ``record`` (its beats), ``line`` and ``hit``, and ``error``: it could not be fetched when it was put
        there, and its beats mean nothing.
    o_fetch
        ``slot`` and ``key`` of a record that is asked of memory.
    i_fill
        ``slot``, ``beat`` (its number), ``data`` and ``error``. The beats of a slot come in their order, one ``error``
        is enough for all; those of different slots in any order. Always ready.
    hits, misses
        Since it was made empty.

    Timing
    ------
    Latency: ``9`` cycles of a hit, 7 under ``LFU`` (`latency_of`), if nothing is in front of it. One hit per cycle; a
    miss takes a cycle too, but see `LfuPlacement`. Stalls with ``o``, and while ``cache_fetches`` fetches or 32
    requests are under way. An invalidation takes ``1`` cycle, or a sweep, see `SetPlacement`.

    Errors
    ------
    ValueError
        Lines, beats or policies out of range.

    Golden counterpart: `golden.memsys.cache.Cache`. Source: Shen 1993, section 5.3.7.
    """

    # Requests under way: more than placements hold, so that what follows a miss is looked up while it is fetched.
    room = 32

    def __init__(self, beat, *, beats: int, config: Config, lines: int, key, tag,
                 policies: tuple[CachePolicy, ...] = tuple(CachePolicy)):
        if not isinstance(beats, int) or beats < 1:
            raise ValueError(f"Beats must be at least 1, not {beats!r}")
        if not policies or not all(isinstance(policy, CachePolicy) for policy in policies):
            raise ValueError(f"Policies must be at least one CachePolicy, not {policies!r}")
        memsys = config.memsys
        self._ways = memsys.cache_ways if CachePolicy.LRU in policies else 1
        if not isinstance(lines, int) or lines < 2 * self._ways or lines & (lines - 1):
            raise ValueError(f"Lines must be a power of two of at least {2 * self._ways}, not {lines!r}")
        self._memsys, self._beats, self._policies = memsys, beats, tuple(policies)
        request = StructLayout({"tag": tag, "key": key})
        self._slot, self._fetches = range(memsys.cache_fetches), memsys.cache_fetches
        self._record = StructLayout({"beats": ArrayLayout(beat, beats), "error": 1})
        self._request, self._key, self._lines = request, key, lines
        super().__init__({
            "i_invalidate": In(stream.Signature(CachePolicy)),
            "i": In(stream.Signature(request)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "record": ArrayLayout(beat, beats),
                                                    "line": range(lines), "hit": 1, "error": 1}))),
            "o_fetch": Out(stream.Signature(StructLayout({"slot": self._slot, "key": key}))),
            "i_fill": In(stream.Signature(StructLayout({"slot": self._slot, "beat": range(beats), "data": beat,
                                                        "error": 1}), always_ready=True)),
            "hits": Out(32), "misses": Out(32)})
        self.latency = self.latency_of(self._policies[0])

    def latency_of(self, policy: CachePolicy) -> int:
        """Of a hit under a policy: that of the placement, of the answers, and three to the record."""
        return (LfuPlacement if policy is CachePolicy.LFU else SetPlacement).latency + 4

    def _placements(self):
        """By name; what is looked up keeps its request, as a miss needs the key."""
        memsys, given = self._memsys, {"key": self._key, "tag": self._request}
        if self._policies != (CachePolicy.LFU,):
            yield "sets", SetPlacement(lines=self._lines, ways=self._ways, **given,
                                       generation_bits=memsys.cache_generation_bits)
        if CachePolicy.LFU in self._policies:
            yield "lfu", LfuPlacement(lines=min(self._lines, memsys.lfu_lines), **given,
                                      count_bits=memsys.lfu_count_bits)

    def elaborate(self, platform):
        m = Module()
        answer = StructLayout({"tag": self._request["tag"].shape, "line": range(self._lines), "hit": 1})
        m.submodules.gate = gate = CreditGate(self._request, credits=self.room)
        m.submodules.answers = answers = Queue(answer, depth=self.room)
        m.submodules.wanted = wanted = Queue(self._key, depth=self.room)
        m.d.comb += gate.i_return.valid.eq(answers.o.valid & answers.o.ready)
        policy = self._add_start(m, gate, placements := dict(self._placements()))
        self._add_lookup(m, gate, placements, policy, answers, wanted)
        self._add_data(m, answers, wanted)
        return m

    def _add_start(self, m, gate, placements):
        """Invalidations wait for all requests, and requests for invalidations; the policy."""
        ready, idle, taken = Signal(), Signal(), Signal()
        policy = Signal(CachePolicy, init=self._policies[0])
        m.d.comb += [
            idle.eq(gate.level == 0), self.i_invalidate.ready.eq(idle), gate.i.payload.eq(self.i.payload),
            taken.eq(self.i_invalidate.valid & self.i_invalidate.ready)]
        with m.If(ready & ~self.i_invalidate.valid):
            m.d.comb += [gate.i.valid.eq(self.i.valid), self.i.ready.eq(gate.i.ready)]
        for name, placement in placements.items():
            m.submodules[name] = placement
            m.d.comb += placement.i_start.valid.eq(taken)
            if name == "sets":
                m.d.comb += [placement.direct.eq(policy == CachePolicy.DIRECT),
                             placement.i_start.valid.eq(self.i_invalidate.valid & idle),
                             self.i_invalidate.ready.eq(idle & placement.i_start.ready)]
        with m.If(taken):
            m.d.sync += [ready.eq(1), policy.eq(self._policies[0])]
            for built in self._policies:
                with m.If(self.i_invalidate.payload == built):
                    m.d.sync += policy.eq(built)
        return policy

    def _add_lookup(self, m, gate, placements, policy, answers, wanted):
        """Requests to answers, in the placement of the policy, and misses to what is to be fetched."""
        for name, placement in placements.items():
            mine = (policy == CachePolicy.LFU) == (name == "lfu")
            m.d.comb += [placement.i.payload.tag.eq(gate.o.payload), placement.i.payload.key.eq(gate.o.payload.key),
                         placement.i.valid.eq(gate.o.valid & mine)]
            with m.If(mine):
                m.d.comb += gate.o.ready.eq(placement.i.ready)
            found = placement.o.payload
            with m.If(placement.o.valid):
                m.d.comb += [
                    answers.i.valid.eq(1), answers.i.payload.tag.eq(found.tag.tag), answers.i.payload.hit.eq(found.hit),
                    answers.i.payload.line.eq(found.line), wanted.i.payload.eq(found.tag.key),
                    wanted.i.valid.eq(~found.hit)]
        m.d.sync += [self.hits.eq(self.hits + (answers.i.valid & answers.i.payload.hit)),
                     self.misses.eq(self.misses + wanted.i.valid)]
        with m.If(self.i_invalidate.valid & self.i_invalidate.ready):
            m.d.sync += [self.hits.eq(0), self.misses.eq(0)]

    def _add_data(self, m, answers, wanted):
        """Fetches, and in the order of the answers what is in the lines."""
        fetches, beats = self._fetches, self._beats
        # Slots are given out, filled and emptied round and round; their number is a power of two.
        asked, awaited = Signal(self._slot), Signal(self._slot)
        used, there, errors = Signal(range(fetches + 1)), Signal(fetches), Signal(fetches)
        asks, takes, frees, advance = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            self.o_fetch.valid.eq(wanted.o.valid & (used != fetches)), self.o_fetch.payload.key.eq(wanted.o.payload),
            self.o_fetch.payload.slot.eq(asked), asks.eq(self.o_fetch.valid & self.o_fetch.ready),
            wanted.o.ready.eq(asks)]
        m.d.sync += [asked.eq(asked + asks), used.eq(used + asks - frees)]

        # One narrow memory for each beat, read together.
        fill, filled = self.i_fill.payload, Signal(self._record)
        hit, line, slot, tag, same = ([Signal.like(value, reset_less=True, name=f"{name}_{age}") for age in (1, 2)]
                                      for name, value in (("hit", self.o.payload.hit), ("line", self.o.payload.line),
                                                          ("slot", asked), ("tag", self.o.payload.tag),
                                                          ("same", Signal())))
        valid = [Signal(name=f"valid_{age}") for age in (1, 2)]
        for beat in range(beats):
            memory = Memory(shape=self._record["beats"].shape.elem_shape, depth=fetches, init=[],
                            attrs={"ram_style": "distributed"})
            m.submodules[f"fill_{beat}"] = memory
            write, read = memory.write_port(), memory.read_port(domain="comb")
            m.d.comb += [write.addr.eq(fill.slot), write.data.eq(fill.data),
                         write.en.eq(self.i_fill.valid & (fill.beat == beat)), read.addr.eq(slot[0]),
                         filled.beats[beat].eq(read.data)]
        m.d.comb += filled.error.eq(errors.bit_select(slot[0], 1))
        with m.If(takes & ~answers.o.payload.hit):
            m.d.sync += [there.bit_select(awaited, 1).eq(0), awaited.eq(awaited + 1)]
        with m.If(self.i_fill.valid):
            m.d.sync += errors.bit_select(fill.slot, 1).eq(
                fill.error | ((fill.beat != 0) & errors.bit_select(fill.slot, 1)))
            with m.If(fill.beat == beats - 1):
                m.d.sync += there.bit_select(fill.slot, 1).eq(1)

        # The answer whose turn it is goes when its record is there, or in a line.
        first = answers.o.payload
        m.d.comb += [answers.o.ready.eq(advance & (first.hit | there.bit_select(awaited, 1))),
                     takes.eq(answers.o.valid & answers.o.ready), advance.eq(self.o.ready | ~self.o.valid),
                     frees.eq(advance & valid[0] & ~hit[0])]
        with m.If(takes):
            m.d.sync += [hit[0].eq(first.hit), line[0].eq(first.line), tag[0].eq(first.tag), slot[0].eq(awaited),
                         same[0].eq(self._repeats(first, line[0]))]
        # What is read of a line that is being written is not used.
        m.submodules.lines = lines = Memory(shape=self._record, depth=self._lines, init=[], attrs={"no_rw_check": 1})
        read, write = lines.read_port(domain="comb"), lines.write_port()
        kept, fetched = (Signal(self._record, reset_less=True, name=name) for name in ("kept", "fetched"))
        m.d.comb += [read.addr.eq(line[0]), write.addr.eq(line[1]), write.data.eq(fetched),
                     write.en.eq(valid[1] & ~hit[1])]
        with m.If(advance):
            m.d.sync += [valid[0].eq(takes), valid[1].eq(valid[0]), self.o.valid.eq(valid[1]), kept.eq(read.data),
                         fetched.eq(filled)]
            m.d.sync += [later.eq(earlier) for earlier, later in (hit, line, tag, same)]
        shown = Signal.like(self.o.payload, reset_less=True)
        m.d.comb += self.o.payload.eq(shown)
        with m.If(advance & valid[1]):
            m.d.sync += [shown.tag.eq(tag[1]), shown.line.eq(line[1]), shown.hit.eq(hit[1])]
            with m.If(~same[1]):
                record = Mux(hit[1], kept.as_value(), fetched.as_value())
                m.d.sync += [shown.record.eq(record[:-1]), shown.error.eq(record[-1])]

    def _repeats(self, answer, line):
        """Whether an answer shows what the one in front of it shows: what is still being written cannot be read."""
        return answer.hit & (answer.line == line)
