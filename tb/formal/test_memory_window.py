import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal
from amaranth.lib import wiring

from golden.config import PRESETS
from hw.memsys.main_memory_port import MainMemoryPort
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

# Bursts of two beats, requests of up to four, pages of 4096 bytes among 65536.
CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
LOW = 3
ENGINE = "abc bmc3"
FAULTS = {
    "reads a beat more": {"axi__arlen": lambda dut: dut.axi.arlen + (dut.axi.araddr[LOW + 1])},
    "reads one after it": {"axi__araddr": lambda dut: dut.axi.araddr + 8},
    "writes in front of it": {"axi__awaddr": lambda dut: dut.axi.awaddr ^ 0x8000},
}


class MemoryWindow(wiring.Component):
    """Every byte of every burst lies in the window, whatever the clients ask for, and in the memory in any order.

    Also: a burst stays within a page, and does not begin inside a beat. The windows stay; all else is free.
    """

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        for interface in (self.i_read, self.i_write, self.i_write_data):
            add_rules(m, interface, Assume)
        for channel, window in ("ar", self.read_window), ("aw", self.write_window):
            valid, address, length = (getattr(self.axi, f"{channel}{name}") for name in ("valid", "addr", "len"))
            last = Signal(20, name=f"last_{channel}")
            before, known = Signal.like(window.as_value(), name=f"before_{channel}"), Signal(name=f"known_{channel}")
            m.d.sync += [before.eq(window), known.eq(1)]
            m.d.comb += [Assume(~known | (before == window.as_value())),
                         last.eq(address + (length << LOW) + (1 << LOW) - 1)]
            with m.If(valid):
                m.d.comb += [Assert(address >= window.base), Assert(last < window.limit),
                             Assert(address[:LOW] == 0), Assert(address[12:] == last[12:]),
                             Cover((address == window.base) & (last == window.limit - 1) & (length == 1))]
        return m


def make():
    return MainMemoryPort(config=CONFIG, tag=1)


def test_nothing_outside_the_window():
    assert prove(MemoryWindow(make()), mode="bmc", depth=12, engine=ENGINE)


def test_reaches_the_ends_of_the_window():
    assert prove(MemoryWindow(make()), mode="cover", depth=10)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    assert not prove(MemoryWindow(NegativeControl(make(), FAULTS[fault])), mode="bmc", depth=12, engine=ENGINE)
