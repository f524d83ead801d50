"""What the bus interface offers its arbiter stays as it is until it is taken."""

import random

import pytest
from amaranth.sim import Simulator

from golden.engine.config import PRESETS
from hw.lib.arbiter import Arbiter
from hw.lib.payload import pack
from hw.memsys.patches import local_bus_interface
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.path_formats import PathFormats, RequestKind

CONFIG = PRESETS["tiny"]
FORMATS = PathFormats(CONFIG)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.sim) for seed in (1, 2, 3))])
def test_an_offer_stays_until_it_is_taken(monkeypatch, seed):
    built = []

    def keep(*given, **named):
        built.append(Arbiter(*given, **named))
        return built[-1]

    monkeypatch.setattr(local_bus_interface, "Arbiter", keep)
    dut, draw, taken = LocalBusInterface(config=CONFIG), random.Random(seed), []

    async def bench(ctx):
        offer = built[0].i[0]
        outstanding, before = [], None
        ctx.set(dut.o_listed.ready, 1)
        for _ in range(3000):
            ctx.set(dut.i_cell.valid, 1)
            ctx.set(dut.i_cell.payload, len(taken) % 7)
            ctx.set(dut.o_request.ready, draw.random() < 0.2)
            replies = bool(outstanding) and draw.random() < 0.3
            ctx.set(dut.i_reply.valid, replies)
            if replies:
                # An empty part with another one behind it, three times out of four.
                beat = {"number": 0, "is_id": 0, "more": int(draw.random() < 0.75)}
                ctx.set(dut.i_reply.payload, {"cluster": 0, "kind": RequestKind.CELL, "last": 1, "error": 0, "hit": 0,
                                              "data": pack(FORMATS.cell_beat, beat)})
                outstanding.pop(0)
            now = (ctx.get(offer.valid), ctx.get(offer.payload.as_value()))
            assert before is None or now == before, "an offer has changed before it was taken"
            before = now if now[0] and not ctx.get(offer.ready) else None
            if ctx.get(dut.o_request.valid) and ctx.get(dut.o_request.ready):
                outstanding.append(ctx.get(dut.o_request.payload.as_value()))
                taken.append(outstanding[-1])
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert len(taken) > 100
