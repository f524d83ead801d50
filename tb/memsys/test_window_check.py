"""Windows are compared in all of their 64 bits: none is cut off at the width of an address."""

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.memsys.fault import Fault
from hw.memsys.window_check import WindowCheck

CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 48})
TOP = 1 << CONFIG.memory.address_bits
BEAT = CONFIG.memory.beat_bytes


def is_bad(window, address, beats=1):
    """What the check says of a request."""
    dut, found = WindowCheck(config=CONFIG, tag=1, fault=Fault.READ_OUTSIDE), []

    async def bench(ctx):
        ctx.set(dut.window, dict(zip(("base", "limit"), window, strict=True)))
        ctx.set(dut.i.payload, {"address": address, "length": beats - 1, "tag": 0})
        ctx.set(dut.i.valid, 1)
        ctx.set(dut.o.ready, 1)
        await ctx.tick()
        ctx.set(dut.i.valid, 0)
        while not ctx.get(dut.o.valid):
            await ctx.tick()
        found.append((ctx.get(dut.o.payload.bad), ctx.get(dut.o_fault.valid)))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    (bad, reported), = found
    assert bad == reported
    return bool(bad)


@pytest.mark.parametrize(("window", "address", "beats", "bad"), [
    ((0, TOP), 0, 1, False), ((0, TOP), TOP - BEAT, 1, False), ((0, TOP), TOP - BEAT, 2, True),
    ((0, TOP - BEAT), TOP - BEAT, 1, True), ((0, TOP + BEAT), TOP - BEAT, 1, False),
    ((0, (1 << 64) - 1), TOP - BEAT, 1, False), ((0, (1 << 64) - 1), TOP - BEAT, 2, True),
    ((0, TOP), 4, 1, True), ((0, 0), 0, 1, True),
    # A base beyond all addresses is not one near 0, nor is such a limit.
    ((TOP, TOP + 64), 0, 1, True), ((1 << 63, (1 << 63) + 64), 0, 1, True), ((TOP + 64, 1 << 63), 128, 1, True),
    ((64, TOP + 32), 64, 8, False), ((64, TOP + 32), 0, 1, True),
    # Windows need not begin or end with a beat.
    *(((0, 4 * BEAT + rest), (4 - beats) * BEAT, beats, rest < 0) for rest in (-1, 0, 1) for beats in (1, 4)),
    *(((4 * BEAT + rest, TOP), 4 * BEAT, beats, rest > 0) for rest in (-1, 0, 1) for beats in (1, 4)),
    ((BEAT, 2 * BEAT), BEAT, 1, False), ((BEAT, 2 * BEAT - 1), BEAT, 1, True), ((BEAT + 1, 2 * BEAT), BEAT, 1, True)])
def test_a_window(window, address, beats, bad):
    assert is_bad(window, address, beats) == bad
