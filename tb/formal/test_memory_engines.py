import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout

from golden.config import PRESETS
from hw.lib.queue import Queue
from hw.memsys.burst_splitter import BurstSplitter
from hw.memsys.fault import Fault
from hw.memsys.read_engine import ReadEngine
from hw.memsys.window_check import WindowCheck
from hw.memsys.write_engine import WriteEngine
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import StreamRules, add_rules

CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
BURST_BEATS, SLOTS, TAG = 2, 2, 2
ENGINE = "abc bmc3"
# Cycles without a reply while memory is silent: the time-out, and the way to it and from it.
PATIENCE = (1 << CONFIG.memory.timeout_bits) + 8


def transfers(interface):
    return interface.valid & interface.ready


class ReadsAnswered(wiring.Component):
    """Whatever memory does, every burst gets as many beats as it has, once, in order.

    Memory may answer anything at any time, or nothing.

    Parameters
    ----------
    dut
        The engine.
    silent
        Memory never answers; then no reply takes longer than `PATIENCE` cycles.
    """

    def __init__(self, dut, *, silent=False):
        self._dut, self._silent = dut, silent
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.i, Assume)
        about = StructLayout({"length": self.i.payload.length.shape(), "tag": TAG, "ends": 1, "bad": 1})
        # Two more are in the pipeline behind the slots.
        m.submodules.asked = asked = Queue(about, depth=SLOTS + 3)
        beat, idle = Signal(2), Signal(range(PATIENCE + 2))
        at_end = beat == asked.o.payload.length
        m.d.comb += [asked.i.valid.eq(transfers(self.i)), asked.o.ready.eq(transfers(self.o) & at_end),
                     *(asked.i.payload[name].eq(self.i.payload[name]) for name in about.members)]
        with m.If(transfers(self.i)):
            m.d.comb += Assert(asked.i.ready)
        with m.If(self.o.valid):
            m.d.comb += [Assert(asked.o.valid), Assert(self.o.payload.tag == asked.o.payload.tag),
                         Assert(self.o.payload.last == (asked.o.payload.ends & at_end)),
                         Assert(self.o.payload.error | ~asked.o.payload.bad),
                         *([] if self._silent else [Cover(~self.o.payload.error & self.o.payload.last & (beat == 1))]),
                         Cover(self.o.payload.error & ~asked.o.payload.bad)]
        with m.If(transfers(self.o)):
            m.d.sync += beat.eq(beat + 1)
            with m.If(at_end):
                m.d.sync += beat.eq(0)
        if self._silent:
            with m.If(~asked.o.valid | ~self.o.ready | self.o.valid):
                m.d.sync += idle.eq(0)
            with m.Else():
                m.d.sync += idle.eq(idle + 1)
            m.d.comb += [Assume(~self.i_data.valid), Assert(idle <= PATIENCE)]
        return m


class WritesAnswered(wiring.Component):
    """Whatever memory does, every request is answered once, in order; as an error if a part of it was bad.

    Memory may answer anything at any time, or nothing.
    """

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        for interface in (self.i, self.i_data, self.i_response):
            add_rules(m, interface, Assume)
        m.submodules.asked = asked = Queue(StructLayout({"tag": TAG, "bad": 1}), depth=SLOTS + 3)
        bad = Signal()
        with m.If(transfers(self.i)):
            m.d.sync += bad.eq((bad | self.i.payload.bad) & ~self.i.payload.ends)
            m.d.comb += Assert(asked.i.ready)
        m.d.comb += [asked.i.valid.eq(transfers(self.i) & self.i.payload.ends),
                     asked.i.payload.tag.eq(self.i.payload.tag), asked.i.payload.bad.eq(bad | self.i.payload.bad),
                     asked.o.ready.eq(transfers(self.o))]
        with m.If(self.o.valid):
            m.d.comb += [Assert(asked.o.valid), Assert(self.o.payload.tag == asked.o.payload.tag),
                         Assert(self.o.payload.error | ~asked.o.payload.bad), Cover(~self.o.payload.error),
                         Cover(self.o.payload.error & ~asked.o.payload.bad)]
        return m


class BurstsCover(wiring.Component):
    """The bursts of a request, of any request, follow each other and are all of it; none crosses a page."""

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.i, Assume)
        given, burst = self.i.payload, self.o.payload
        # Lengths of more than there can be do not come out of the window check.
        m.d.comb += Assume((given.last - given.first)[:len(given.first)] < 1 << CONFIG.memory.length_bits)
        m.submodules.asked = asked = Queue(self.i.payload.shape(), depth=2)
        next_beat, begun = Signal.like(given.first), Signal()
        last = Signal.like(given.first)
        m.d.comb += [asked.i.valid.eq(transfers(self.i)), asked.i.payload.eq(given),
                     last.eq(burst.first + burst.length), asked.o.ready.eq(transfers(self.o) & burst.ends)]
        with m.If(transfers(self.o)):
            m.d.sync += [next_beat.eq(last + 1), begun.eq(~burst.ends)]
        with m.If(self.o.valid):
            m.d.comb += [
                Assert(asked.o.valid), Assert(burst.tag == asked.o.payload.tag),
                Assert(burst.bad == asked.o.payload.bad), Assert(begun | (burst.first == asked.o.payload.first)),
                Assert(~begun | (burst.first == next_beat)), Assert(burst.ends == (last == asked.o.payload.last)),
                Assert(burst.first[9:] == last[9:]), Cover(begun & burst.ends & (burst.length == 1))]
        return m


BENCHES = {"read": (ReadsAnswered, ReadEngine), "write": (WritesAnswered, WriteEngine)}
FAULTS = {
    "read": {
        "a beat too many": {"o__valid": lambda dut: dut.o.valid | transfers(dut.i)},
        "another tag": {"o__payload": lambda dut: dut.o.payload.as_value() ^ (dut.o.payload.last << 64)},
        "never an error": {"o__payload": lambda dut: dut.o.payload.as_value()[:-1]},
    },
    "write": {
        "answers twice": {"o__valid": lambda dut: dut.o.valid | transfers(dut.i)},
        "another tag": {"o__payload": lambda dut: dut.o.payload.as_value() ^ transfers(dut.i)},
        "never an error": {"o__payload": lambda dut: dut.o.payload.as_value() & 0b011},
    },
}


def bench(kind, faults=None, **more):
    bench, engine = BENCHES[kind]
    dut = engine(config=CONFIG, tag=TAG)
    return bench(NegativeControl(dut, faults) if faults else dut, **more)


@pytest.mark.parametrize("kind", BENCHES)
def test_answered_once(kind):
    assert prove(bench(kind), mode="bmc", depth=12, engine=ENGINE)


@pytest.mark.nightly
def test_silence_is_answered():
    assert prove(bench("read", silent=True), mode="bmc", depth=PATIENCE + 4, engine=ENGINE)


@pytest.mark.parametrize("kind", BENCHES)
def test_reaches_answers_and_errors(kind):
    assert prove(bench(kind), mode="cover", depth=14)


def test_one_that_waits_for_ever():
    faults = {"o__valid": lambda dut: dut.o.valid & ~dut.o.payload.error}
    assert not prove(bench("read", faults, silent=True), mode="bmc", depth=PATIENCE + 4)


@pytest.mark.parametrize(("kind", "fault"), [(kind, fault) for kind, faults in FAULTS.items() for fault in faults])
def test_negative_control(kind, fault):
    assert not prove(bench(kind, FAULTS[kind][fault]), mode="bmc", depth=14)


@pytest.mark.parametrize("kind", BENCHES)
def test_rules_of_the_engines(kind):
    dut = BENCHES[kind][1](config=CONFIG, tag=TAG)
    assert prove(StreamRules(dut), mode="bmc", depth=14, engine=ENGINE)


def test_rules_of_the_window_check():
    assert prove(StreamRules(WindowCheck(config=CONFIG, tag=TAG, fault=Fault.READ_OUTSIDE)))


def test_bursts_are_the_request():
    assert prove(BurstsCover(BurstSplitter(config=CONFIG, tag=TAG)), mode="bmc", depth=10, engine=ENGINE)
    assert prove(BurstsCover(BurstSplitter(config=CONFIG, tag=TAG)), mode="cover", depth=10)


def test_a_splitter_that_begins_again():
    faults = {"o__payload": lambda dut: dut.o.payload.as_value() ^ dut.o.payload.ends}
    assert not prove(BurstsCover(NegativeControl(BurstSplitter(config=CONFIG, tag=TAG), faults)), mode="bmc", depth=8,
                     engine=ENGINE)
