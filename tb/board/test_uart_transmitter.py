"""Bytes on a serial line."""

import random
from itertools import pairwise

import pytest

from hw.board.uart_transmitter import UartTransmitter
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of
from tb.lib.timing import documented_latency

BYTES = [0x00, 0xFF, 0x55, 0xAA, 0x01, 0x80, *random.Random(3).randbytes(40)]


def levels(divisor, gaps=0):
    """The line in each cycle, and the cycles in which a byte is taken."""
    component, line, taken, chance = UartTransmitter(divisor=divisor), [], [], random.Random(1)
    simulator = simulator_of(component)

    async def drive(ctx):
        for value in BYTES:
            ctx.set(component.i.payload, value)
            ctx.set(component.i.valid, 1)
            while not (await ctx.tick().sample(component.i.ready))[2]:
                pass
            ctx.set(component.i.valid, 0)
            if gaps:
                await ctx.tick().repeat(chance.randint(1, gaps))
        await ctx.tick().repeat(12 * divisor)

    async def watch(ctx):
        while True:
            *_, tx, valid, ready = await ctx.tick().sample(component.tx, component.i.valid, component.i.ready)
            if valid and ready:
                taken.append(len(line))
            line.append(tx)

    simulator.add_testbench(drive)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    return line, taken


def received(line, divisor):
    """What a receiver that looks into the middle of bits makes of it."""
    found, at = [], 0
    while at < len(line):
        if line[at]:
            at += 1
            continue
        bits = [line[at + divisor * k + divisor // 2] for k in range(10)]
        assert (bits[0], bits[9]) == (0, 1)
        found.append(sum(bit << k for k, bit in enumerate(bits[1:9])))
        at += 10 * divisor
    return found


@pytest.mark.parametrize("divisor", [1, 4, 7])
def test_bytes_arrive(divisor):
    for gaps in 0, 30:
        line, taken = levels(divisor, gaps)
        assert received(line, divisor) == BYTES
        assert line[:taken[0] + 1] == [1] * (taken[0] + 1)
        assert line.index(0) - taken[0] == UartTransmitter.latency
        if not gaps:
            assert [b - a for a, b in pairwise(taken)] == [10 * divisor] * (len(BYTES) - 1)
    assert documented_latency(UartTransmitter, config_of({})) == UartTransmitter.latency


def test_init_wrong_divisor():
    with pytest.raises(ValueError, match=r"^Divisor must be at least 1, not 0$"):
        UartTransmitter(divisor=0)
