from amaranth.hdl import Assert, Assume, Cover, Signal
from amaranth.lib.data import StructLayout

from golden.engine.config import PRESETS
from hw.lib.queue import Queue
from hw.memsys.port.burst_splitter import BurstSplitter
from hw.memsys.port.read_engine import ReadEngine
from hw.memsys.port.write_engine import WriteEngine
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules

CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
SLOTS, TAG = 2, 2
ENGINE = "abc bmc3"
# Cycles without a reply while memory is silent: the time-out, and the way to it and from it.
LIMIT = (1 << CONFIG.memory.timeout_bits) + 8
# Likewise of a write, whose beats take one more each.
WRITE_LIMIT = LIMIT + SLOTS * CONFIG.memory.burst_beats - 1


def reads_answered(m, bench, dut, silent):
    """Whatever memory does, every burst gets as many beats as it has, once, in order.

    Memory may answer anything at any time, or nothing; ``silent``: it never answers, and no reply takes longer than
    `LIMIT` cycles.
    """
    add_rules(m, dut.i, Assume)
    about = StructLayout({"length": dut.i.payload.length.shape(), "tag": TAG, "ends": 1, "bad": 1})
    # Two more are in the pipeline behind the slots.
    m.submodules.requested = requested = Queue(about, depth=SLOTS + 3)
    beat, idle = Signal(2), Signal(range(LIMIT + 2))
    at_end, answer, head = beat == requested.o.payload.length, dut.o.payload, requested.o.payload
    m.d.comb += [requested.i.valid.eq(transfers(dut.i)), requested.o.ready.eq(transfers(dut.o) & at_end),
                 *(requested.i.payload[name].eq(dut.i.payload[name]) for name in about.members)]
    with m.If(transfers(dut.i)):
        m.d.comb += Assert(requested.i.ready, "capacity")
    with m.If(dut.o.valid):
        m.d.comb += [Assert(requested.o.valid, "requested"), Assert(answer.tag == head.tag, "tag"),
                     Assert(answer.last == (head.ends & at_end), "last"), Assert(answer.error | ~head.bad, "error"),
                     Cover(answer.error & ~head.bad, "error")]
        if not silent:
            m.d.comb += Cover(~answer.error & answer.last & (beat == 1), "two beats")
    with m.If(transfers(dut.o)):
        m.d.sync += beat.eq(beat + 1)
        with m.If(at_end):
            m.d.sync += beat.eq(0)
    if silent:
        with m.If(~requested.o.valid | ~dut.o.ready | dut.o.valid):
            m.d.sync += idle.eq(0)
        with m.Else():
            m.d.sync += idle.eq(idle + 1)
        m.d.comb += [Assume(~dut.i_data.valid), Assert(idle <= LIMIT, "progress")]


def writes_answered(m, bench, dut, silent, limit=WRITE_LIMIT):
    """Whatever memory does, every request is answered once, in order; as an error if a part of it was bad.

    Memory may answer anything at any time, or nothing; ``silent``: it never answers, accepts all addresses and data or
    none, and no request whose data come takes longer than ``limit`` cycles.
    """
    for interface in (dut.i,) if silent else (dut.i, dut.i_data, dut.i_response):
        add_rules(m, interface, Assume)
    m.submodules.requested = requested = Queue(StructLayout({"tag": TAG, "bad": 1}), depth=SLOTS + 3)
    bad, answer, head = Signal(), dut.o.payload, requested.o.payload
    with m.If(transfers(dut.i)):
        m.d.sync += bad.eq((bad | dut.i.payload.bad) & ~dut.i.payload.ends)
        m.d.comb += Assert(requested.i.ready, "capacity")
    m.d.comb += [requested.i.valid.eq(transfers(dut.i) & dut.i.payload.ends),
                 requested.i.payload.tag.eq(dut.i.payload.tag), requested.i.payload.bad.eq(bad | dut.i.payload.bad),
                 requested.o.ready.eq(transfers(dut.o))]
    with m.If(dut.o.valid):
        m.d.comb += [Assert(requested.o.valid, "requested"), Assert(answer.tag == head.tag, "tag"),
                     Assert(answer.error | ~head.bad, "error"), Cover(answer.error & ~head.bad, "error")]
        if not silent:
            m.d.comb += Cover(~answer.error, "answer")
    if silent:
        accepts, idle = bench.choose(m, 2, "accepts"), Signal(range(limit + 2))
        with m.If(~requested.o.valid | ~dut.o.ready | dut.o.valid):
            m.d.sync += idle.eq(0)
        with m.Else():
            m.d.sync += idle.eq(idle + 1)
        m.d.comb += [Assume(~dut.i_response.valid), Assume(dut.i_data.valid), Assert(idle <= limit, "progress"),
                     Assume(dut.o_address.ready == accepts[0]), Assume(dut.o_data.ready == accepts[1]),
                     Cover(idle == (1 << CONFIG.memory.timeout_bits), "waits")]


def bursts_of_requests(m, bench, dut):
    """The bursts of a request, of any request, follow each other and are all of it; none crosses a page."""
    add_rules(m, dut.i, Assume)
    given, burst = dut.i.payload, dut.o.payload
    # The window check lets no longer request through.
    m.d.comb += Assume((given.last - given.first)[:len(given.first)] < 1 << CONFIG.memory.length_bits)
    m.submodules.requested = requested = Queue(given.shape(), depth=2)
    head, next_beat, begun, last = requested.o.payload, Signal.like(given.first), Signal(), Signal.like(given.first)
    m.d.comb += [requested.i.valid.eq(transfers(dut.i)), requested.i.payload.eq(given),
                 last.eq(burst.first + burst.length), requested.o.ready.eq(transfers(dut.o) & burst.ends)]
    with m.If(transfers(dut.o)):
        m.d.sync += [next_beat.eq(last + 1), begun.eq(~burst.ends)]
    with m.If(dut.o.valid):
        m.d.comb += [
            Assert(requested.o.valid, "requested"), Assert(burst.tag == head.tag, "tag"),
            Assert(burst.bad == head.bad, "bad"),
            Assert(begun | (burst.first == head.first), "first"), Assert(~begun | (burst.first == next_beat), "next"),
            Assert(burst.ends == (last == head.last), "last"), Assert(burst.first[9:] == last[9:], "page"),
            Cover(begun & burst.ends & (burst.length == 1), "a second burst of two beats")]


test_reads = declare(
    lambda silent=False: Bench(reads_answered, ReadEngine(config=CONFIG, tag=TAG), silent=silent),
    cycles=12, engine=ENGINE, covers_nightly=True,
    claims=[Claim(), Claim(silent=True, cycles=LIMIT + 4, nightly=True)],
    controls={
        "a beat too many": Control("requested", {"o__valid": lambda dut: dut.o.valid | transfers(dut.i)}),
        "another tag": Control(
            "tag", {"o__payload": lambda dut: dut.o.payload.as_value() ^ (dut.o.payload.last << 64)}),
        "never an error": Control("error", {"o__payload": lambda dut: dut.o.payload.as_value()[:-1]}),
        "waits without end": Control(
            "progress", {"o__valid": lambda dut: dut.o.valid & ~dut.o.payload.error}, silent=True, nightly=True),
    })
test_writes = declare(
    lambda silent=False, **more: Bench(writes_answered, WriteEngine(config=CONFIG, tag=TAG), silent=silent, **more),
    # The rest holds whatever memory answers; all at once does not end in 24 cycles.
    cycles=12, engine=ENGINE, covers_nightly=True,
    claims=[Claim(), Claim(silent=True, cycles=24, only="progress")],
    controls={
        "a shorter limit": Control("progress", silent=True, limit=WRITE_LIMIT - 1),
        "waits for an answer without end": Control(
            "progress", {"o__valid": lambda dut: dut.o.valid & ~dut.o.payload.error}, silent=True, nightly=True),
        "answers twice": Control("requested", {"o__valid": lambda dut: dut.o.valid | transfers(dut.i)}),
        "another tag": Control("tag", {"o__payload": lambda dut: dut.o.payload.as_value() ^ transfers(dut.i)}),
        "never an error": Control("error", {"o__payload": lambda dut: dut.o.payload.as_value() & 0b011}),
    })
test_bursts = declare(
    lambda: Bench(bursts_of_requests, BurstSplitter(config=CONFIG, tag=TAG)), cycles=10, engine=ENGINE,
    covers_nightly=True,
    controls={
        "begins again": Control("next", {"o__payload": lambda dut: dut.o.payload.as_value() ^ dut.o.payload.ends}),
        "another tag": Control("tag", {"o__payload": lambda dut: dut.o.payload.as_value() ^ (
            1 << dut.o.payload.shape()["tag"].offset)}),
    })
