"""Cache: records by key, from its lines or from memory."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.credit_gate import CreditGate
from hw.lib.queue import Queue
from hw.lib.validate import check_instance, check_integer, check_power_of_two
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.bus.lfu_placement import LfuPlacement
from hw.memsys.bus.set_placement import SetPlacement

__all__ = ["Cache"]


class Cache(wiring.Component):
    """Replies to requests in order: a record from a line, or fetched into one.

    A line is assigned when a request is looked up; its record follows later, in the order of the requests: a hit reads
    its line when it is the oldest request, a miss waits for its fetch and writes the line. So a second request for a
    record that is being fetched is a hit that waits, and a line can be reassigned while its record is outstanding::

        i - credits - placement -+- answers, a queue -+- fill buffer: a miss - line memory -- o
                                 '- o_fetch ... i_fill -'            a hit  -'

    A fetch reserves a slot for the whole record before it is requested. So fills are always accepted, in any order of
    the slots.

    A record that could not be fetched is an error for the requests that were accepted before its reply was due. Then
    no request is accepted until those in flight have been answered, and all lines are emptied: the next request for
    the record fetches it again.

    Parameters
    ----------
    beat, beats
        Shape of a beat, and beats of a record, at least 1.
    config
        The configuration.
    lines
        A power of two.
    key, tag
        Shapes of a key, and of a sideband value of a request.
    policies
        Those that are built; all by default.

    Members
    -------
    i_invalidate : In, stream of `CachePolicy`
        Empties all lines, clears the counters, and sets the policy; a policy that is not built is replaced by the first
        one that is. Accepted when no request is in flight, but not while lines are emptied after an error. Requests are
        accepted after the first one.
    i : In, stream of ``tag``, ``key``
        Requests.
    o : Out, stream of ``tag``, ``record``, ``line``, ``hit``, ``error``
        Replies. ``error``: the record could not be fetched, and its beats are undefined.
    o_fetch : Out, stream of ``slot``, ``key``
        Records to fetch.
    i_fill : In, stream of ``slot``, ``beat``, ``data``, ``error``
        Their beats: those of a slot in order, those of different slots in any order; one ``error`` is enough for a
        record. Always ready.
    hits, misses : Out(32)
        Since the last invalidation.

    Timing
    ------
    Latency: ``9`` cycles of a hit, 7 under ``LFU`` (`latency_of`), if it is the oldest request. One hit per cycle; a
    miss takes a cycle too, but see `LfuPlacement`. Stalls with ``o``, and while ``cache_fetches`` fetches or 32
    requests are in flight. An invalidation takes ``1`` cycle, or a sweep, see `SetPlacement`.

    Raises
    ------
    TypeError
        A number is no integer, or a policy no `CachePolicy`.
    ValueError
        A number is out of range, or there is no policy.

    Golden counterpart: `golden.engine.memsys.bus.cache.Cache`. Source: Shen 1993, section 5.3.7.
    """

    # Requests in flight: more than a placement holds, so that requests after a miss are looked up during its fetch.
    capacity = 32

    def __init__(self, beat, *, beats: int, config: Config, lines: int, key, tag,
                 policies: tuple[CachePolicy, ...] = tuple(CachePolicy)):
        check_integer("Beats", beats, minimum=1)
        for policy in policies:
            check_instance("Policies", policy, CachePolicy)
        if not policies:
            raise ValueError(f"Policies must be at least one CachePolicy, not {policies!r}")
        memsys = config.memsys
        self._ways = memsys.cache_ways if CachePolicy.LRU in policies else 1
        check_power_of_two("Lines", lines, minimum=2 * self._ways)
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
        """The latency of a hit under a policy: the placement's, one for the answers, three for the record."""
        return (LfuPlacement if policy is CachePolicy.LFU else SetPlacement).latency + 4

    def _placements(self):
        """By name. The tag of a lookup is the whole request, as a miss needs the key."""
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
        m.submodules.gate = gate = CreditGate(self._request, credits=self.capacity)
        m.submodules.answers = answers = Queue(answer, depth=self.capacity)
        m.submodules.missed = missed = Queue(self._key, depth=self.capacity)
        m.d.comb += gate.i_return.valid.eq(answers.o.valid & answers.o.ready)
        failed = Signal()
        policy = self._add_start(m, gate, placements := dict(self._placements()), failed)
        self._add_lookup(m, gate, placements, policy, answers, missed)
        self._add_data(m, answers, missed, failed)
        return m

    def _add_start(self, m, gate, placements, failed):
        """Lines are emptied by an invalidation, and when a fetch has failed: that waits for all requests, and requests
        for that. Returns the policy.
        """
        ready, idle, starts, accepts, taken = Signal(), Signal(), Signal(), Signal(), Signal()
        policy = Signal(CachePolicy, init=self._policies[0])
        m.d.comb += [
            idle.eq(gate.level == 0), starts.eq((self.i_invalidate.valid | failed) & idle), accepts.eq(idle),
            self.i_invalidate.ready.eq(accepts & ~failed), gate.i.payload.eq(self.i.payload),
            taken.eq(self.i_invalidate.valid & self.i_invalidate.ready)]
        with m.If(ready & ~self.i_invalidate.valid & ~failed):
            m.d.comb += [gate.i.valid.eq(self.i.valid), self.i.ready.eq(gate.i.ready)]
        for name, placement in placements.items():
            m.submodules[name] = placement
            m.d.comb += placement.i_start.valid.eq(starts & accepts)
            if name == "sets":
                m.d.comb += [placement.direct.eq(policy == CachePolicy.DIRECT), placement.i_start.valid.eq(starts),
                             accepts.eq(idle & placement.i_start.ready)]
        with m.If(starts & accepts):
            m.d.sync += failed.eq(0)
        with m.If(taken):
            m.d.sync += [ready.eq(1), policy.eq(self._policies[0])]
            for built in self._policies:
                with m.If(self.i_invalidate.payload == built):
                    m.d.sync += policy.eq(built)
        return policy

    def _add_lookup(self, m, gate, placements, policy, answers, missed):
        """Requests through the placement of the policy: all to the answers, misses to the fetches."""
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
                    answers.i.payload.line.eq(found.line), missed.i.payload.eq(found.tag.key),
                    missed.i.valid.eq(~found.hit)]
        m.d.sync += [self.hits.eq(self.hits + (answers.i.valid & answers.i.payload.hit)),
                     self.misses.eq(self.misses + missed.i.valid)]
        with m.If(self.i_invalidate.valid & self.i_invalidate.ready):
            m.d.sync += [self.hits.eq(0), self.misses.eq(0)]

    def _add_data(self, m, answers, missed, failed):
        """Fetches, and the records of the answers in order; whether one has ``failed``."""
        fetches, beats = self._fetches, self._beats
        # Slots are assigned, filled and freed in a ring; their number is a power of two.
        newest, awaited = Signal(self._slot), Signal(self._slot)
        used, present, errors = Signal(range(fetches + 1)), Signal(fetches), Signal(fetches)
        issues, takes, frees, advance = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            self.o_fetch.valid.eq(missed.o.valid & (used != fetches)), self.o_fetch.payload.key.eq(missed.o.payload),
            self.o_fetch.payload.slot.eq(newest), issues.eq(self.o_fetch.valid & self.o_fetch.ready),
            missed.o.ready.eq(issues)]
        m.d.sync += newest.eq(newest + issues)
        count_entries(used)
        count_steps(m, used, up=issues, down=frees, most=fetches)
        claim(m, ~self.i_fill.valid | ((self.i_fill.payload.slot - awaited)[:len(awaited)] < used),
              "a fill has a slot in use")

        # A narrow memory for each beat, read together.
        fill, filled = self.i_fill.payload, Signal(self._record)
        hit, line, slot, tag, same = ([Signal.like(value, reset_less=True, name=f"{name}_{age}") for age in (1, 2)]
                                      for name, value in (("hit", self.o.payload.hit), ("line", self.o.payload.line),
                                                          ("slot", newest), ("tag", self.o.payload.tag),
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
            m.d.sync += [present.bit_select(awaited, 1).eq(0), awaited.eq(awaited + 1)]
            with m.If(errors.bit_select(awaited, 1)):
                m.d.sync += failed.eq(1)
        with m.If(self.i_fill.valid):
            m.d.sync += errors.bit_select(fill.slot, 1).eq(
                fill.error | ((fill.beat != 0) & errors.bit_select(fill.slot, 1)))
            with m.If(fill.beat == beats - 1):
                m.d.sync += present.bit_select(fill.slot, 1).eq(1)

        # The oldest answer leaves when its record has been fetched, or is in a line.
        oldest = answers.o.payload
        m.d.comb += [answers.o.ready.eq(advance & (oldest.hit | present.bit_select(awaited, 1))),
                     takes.eq(answers.o.valid & answers.o.ready), advance.eq(self.o.ready | ~self.o.valid),
                     frees.eq(advance & valid[0] & ~hit[0])]
        with m.If(takes):
            m.d.sync += [hit[0].eq(oldest.hit), line[0].eq(oldest.line), tag[0].eq(oldest.tag), slot[0].eq(awaited),
                         same[0].eq(self._repeats(oldest, line[0]))]
        # A read of the line that is written in the same cycle is not used.
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
        """Whether an answer has the record of the previous one, whose line is still being written."""
        return answer.hit & (answer.line == line)
