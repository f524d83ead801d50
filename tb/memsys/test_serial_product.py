"""A product, bit by bit."""

import random

import pytest
from amaranth.sim import Simulator

from hw.memsys.serial_product import SerialProduct


@pytest.mark.parametrize("seed", range(3))
def test_products(seed):
    dut, draw = SerialProduct(a=9, b=5, addend=12), random.Random(seed)
    cases = [(511, 31, 4095), (0, 0, 0), (511, 0, 7), (3, 16, 0)] + [
        (draw.randrange(512), draw.randrange(32), draw.randrange(4096)) for _ in range(20)]

    async def bench(ctx):
        for a, b, addend in cases:
            ctx.set(dut.i.payload, {"a": a, "b": b, "addend": addend})
            ctx.set(dut.i.valid, 1)
            assert ctx.get(dut.i.ready)
            await ctx.tick()
            ctx.set(dut.i.valid, 0)
            latency = 1
            while not ctx.get(dut.o.valid):
                await ctx.tick()
                latency += 1
            assert latency == 1 + b.bit_length() <= dut.latency
            for _ in range(draw.randrange(3)):
                await ctx.tick()
            assert ctx.get(dut.o.payload) == a * b + addend
            ctx.set(dut.o.ready, 1)
            await ctx.tick()
            ctx.set(dut.o.ready, 0)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


def test_arguments_are_checked():
    with pytest.raises(ValueError, match="B must be at least 1, not 0"):
        SerialProduct(a=1, b=0)
    with pytest.raises(TypeError, match="A must be at least 1, not '8'"):
        SerialProduct(a="8", b=1)
