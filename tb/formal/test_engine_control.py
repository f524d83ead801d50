"""A cast always ends: by its units, or by the watchdog."""

from amaranth.hdl import Assert, Assume, Cover, Signal

from golden.config import PRESETS
from hw.control.engine_control import EngineControl
from tb.formal.bench import Bench
from tb.formal.declare import Control, declare
from tb.formal.source_fault import source_fault

CONFIG = PRESETS["tiny"]
# The longest limit of the watchdog, and the cycles from its end to the reset, where it begins in the cycle after the
# start.
LONGEST, LATE = 3, 2
BUSY = {"loads": "loading", "casts": "casting", "writes": "writing"}


def activities_end(m, bench, dut):
    """With the watchdog on, units are reset within a bound after the last start, whatever host, units and memory do; a
    reset that memory does not delay ends.

    Units are busy from the cycle after their start on, for as long as they like, and not after a reset.
    """
    limit = Signal(range(LONGEST + 2))
    m.d.comb += [limit.eq(bench.choose(m, range(LONGEST), "less_one") + 1), dut.watchdog.eq(limit),
                 Assume(limit <= LONGEST)]
    active, starts = Signal(), Signal()
    for busy, begins in BUSY.items():
        before = Signal(name=f"{busy}_before")
        m.d.sync += before.eq((getattr(dut, busy) | getattr(dut, begins)) & ~dut.stops)
        m.d.comb += Assume(~getattr(dut, busy) | before)
    m.d.comb += [active.eq(dut.loads | dut.casts | dut.writes), starts.eq(dut.loading | dut.casting | dut.writing)]
    waits, held = Signal(range(LONGEST + LATE + 3)), Signal(range(6))
    with m.If(~active | starts | dut.stops):
        m.d.sync += waits.eq(0)
    with m.Else():
        m.d.sync += waits.eq(waits + (waits <= limit + LATE))
    with m.If(~dut.stops | dut.memory_busy):
        m.d.sync += held.eq(0)
    with m.Else():
        m.d.sync += held.eq(held + (held != 5))
    m.d.comb += [Assert(waits <= limit + LATE, "active"), Assert(held <= 1, "held"),
                 Cover(dut.stops & dut.casts & (waits == limit + LATE), "a cast ends at the last moment"),
                 Cover(dut.stops & dut.memory_busy, "memory delays the reset")]


def make(kind=EngineControl):
    return Bench(activities_end, kind(config=CONFIG))


test_activities_end = declare(
    make, cycles=16, engine="abc bmc3", covers_nightly=True,
    controls={
        "the watchdog leaves casts alone": Control(
            "active", {"stops": lambda dut: dut.stops & ~dut.casts}, nightly=True),
        "the watchdog is late": Control("active", kind=source_fault(
            EngineControl, "(cycles >= self.watchdog)", "(cycles > self.watchdog)")),
        "a reset stays": Control("held", kind=source_fault(
            EngineControl, "self.stops.eq(self.memory_busy)", "self.stops.eq(self.memory_busy | self.casts)")),
    })
