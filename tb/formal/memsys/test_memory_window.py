from amaranth.hdl import Assert, Assume, Cover, Signal

from golden.engine.config import PRESETS
from hw.memsys.port.main_memory_port import MainMemoryPort
from tb.formal.bench import Bench
from tb.formal.declare import Control, declare
from tb.formal.stream_rules import add_rules

# Bursts of two beats, requests of up to four, pages of 4096 bytes among 65536.
CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
LOW = 3


def within_the_window(m, bench, dut):
    """Every byte of every burst lies in the window, whatever the clients request.

    Also: a burst stays within a page, and does not begin inside a beat. The windows stay, as `hw.engine.Engine` loads
    them when a command begins, before which the port is idle; all else is free.
    """
    for interface in (dut.i_read, dut.i_write, dut.i_write_data):
        add_rules(m, interface, Assume)
    for channel, window in ("ar", dut.read_window), ("aw", dut.write_window):
        valid, address, length = (getattr(dut.axi, f"{channel}{name}") for name in ("valid", "addr", "len"))
        last = Signal(20, name=f"last_{channel}")
        before, known = Signal.like(window.as_value(), name=f"before_{channel}"), Signal(name=f"known_{channel}")
        m.d.sync += [before.eq(window), known.eq(1)]
        m.d.comb += [Assume(~known | (before == window.as_value())),
                     last.eq(address + (length << LOW) + (1 << LOW) - 1)]
        with m.If(valid):
            m.d.comb += [Assert(address >= window.base, f"{channel} begins"),
                         Assert(last < window.limit, f"{channel} ends"),
                         Assert(address[:LOW] == 0, f"{channel} aligned"),
                         Assert(address[12:] == last[12:], f"{channel} page"),
                         Cover((address == window.base) & (last == window.limit - 1) & (length == 1), channel)]


test_memory_window = declare(
    lambda: Bench(within_the_window, MainMemoryPort(config=CONFIG, tag=1)), cycles=12, engine="abc bmc3",
    covers_nightly=True, controls={
        "reads a beat more": Control("ar ends", {"axi__arlen": lambda dut: dut.axi.arlen + (dut.axi.araddr[LOW + 1])}),
        "reads one after it": Control("ar ends", {"axi__araddr": lambda dut: dut.axi.araddr + 8}, nightly=True),
        "writes in front of it": Control("aw begins", {"axi__awaddr": lambda dut: dut.axi.awaddr ^ 0x8000}),
        "reads from inside a beat": Control(
            "ar aligned", {"axi__araddr": lambda dut: dut.axi.araddr | dut.axi.arlen[0]}, nightly=True),
        "crosses a page": Control("aw page", {"axi__awlen": lambda dut: dut.axi.awlen | dut.axi.awaddr[3:12].all()}),
    })
