import pytest
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.memsys.port.read_buffer import ReadBuffer
from tb.lib.schedules import SETTINGS

CONFIG = PRESETS["tiny"].replace({"memory.outstanding": 4, "memory.burst_beats": 4})
SLOTS, BEATS = CONFIG.memory.outstanding, CONFIG.memory.burst_beats


class Model:
    """A burst per slot: its length, the beats that came, whether more are missing, and whether one was wrong."""

    def __init__(self):
        self.length, self.beats = [None] * SLOTS, [[] for _ in range(SLOTS)]
        self.outstanding, self.wrong = [False] * SLOTS, [False] * SLOTS

    def start(self, slot, length):
        self.length[slot], self.beats[slot] = length, []
        self.outstanding[slot], self.wrong[slot] = True, False

    def beat(self, slot, data, last, failed):
        """Whether the beat is stored, and whether it is unexpected."""
        if not self.outstanding[slot]:
            return False, True
        stored = len(self.beats[slot]) <= self.length[slot]
        if stored:
            self.beats[slot].append(data)
        miscounted = not stored or last != (len(self.beats[slot]) - 1 == self.length[slot])
        self.outstanding[slot] = not last
        self.wrong[slot] |= failed or miscounted
        return stored, miscounted


# Few slots, so that bursts of each get too few, enough and too many beats.
SLOT = st.sampled_from([0, 0, 0, SLOTS - 1])
RARE = st.sampled_from([False, False, True])
BEAT = st.tuples(SLOT, st.integers(0, 255), RARE, RARE)
STEP = st.one_of(st.tuples(st.just("start"), SLOT, st.integers(0, BEATS - 1)),
                 st.tuples(st.just("beat"), BEAT), st.tuples(st.just("beat"), BEAT))


@SETTINGS
@given(st.lists(STEP, min_size=20, max_size=40))
def test_beats_of_bursts_in_any_order(steps):
    """Each step takes two cycles, so that what it does is known."""
    dut, model = ReadBuffer(config=CONFIG), Model()

    async def bench(ctx):
        for kind, *what in steps:
            if kind == "start":
                slot, length = what
                if model.outstanding[slot]:
                    continue
                model.start(slot, length)
                ctx.set(dut.start, 1)
                ctx.set(dut.slot, slot)
                ctx.set(dut.length, length)
                await ctx.tick()
                ctx.set(dut.start, 0)
            else:
                (slot, data, last, failed), = what
                stored, unexpected = model.beat(slot, data, last, failed)
                ctx.set(dut.i.payload, {"id": slot, "data": data, "last": last, "response": 2 * failed})
                ctx.set(dut.i.valid, 1)
                await ctx.tick()
                ctx.set(dut.i.valid, 0)
                assert (ctx.get(dut.stored), ctx.get(dut.unexpected), ctx.get(dut.failed), ctx.get(dut.beat_slot)) == (
                    stored, unexpected, failed, slot)
            await ctx.tick()
            assert [ctx.get(dut.outstanding[k]) for k in range(SLOTS)] == model.outstanding
            assert [ctx.get(dut.wrong[k]) for k in range(SLOTS)] == model.wrong
        for slot in range(SLOTS):
            for index, data in enumerate(model.beats[slot]):
                ctx.set(dut.port.addr, slot * BEATS + index)
                ctx.set(dut.port.en, 1)
                await ctx.tick()
                assert ctx.get(dut.port.data) == data

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


@pytest.mark.parametrize(("at", "stored"), [("start", 0), ("offer", 0), ("acceptance", 1)])
def test_a_beat_is_expected_when_memory_has_accepted_its_address(at, stored):
    """Not in the cycle in which its burst begins, and not while the address is offered."""
    dut, slot = ReadBuffer(config=CONFIG), SLOTS - 1

    async def beat(ctx):
        ctx.set(dut.i.payload, {"id": slot, "data": 7, "last": 0, "response": 0})
        ctx.set(dut.i.valid, 1)
        await ctx.tick()
        assert (ctx.get(dut.stored), ctx.get(dut.unexpected)) == (stored, 1 - stored)

    async def bench(ctx):
        ctx.set(dut.slot, slot)
        ctx.set(dut.length, BEATS - 1)
        ctx.set(dut.start, 1)
        if at == "start":
            await beat(ctx)
            return
        await ctx.tick()
        ctx.set(dut.start, 0)
        # An offer of another slot's address does not matter.
        ctx.set(dut.offered, 1)
        ctx.set(dut.offered_slot, slot if at == "offer" else 0)
        await beat(ctx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
