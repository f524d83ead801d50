# amaranth: UnusedElaboratable=no

from random import Random

import pytest
from amaranth.hdl import Const, Module, signed
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hw.lib.pipeline import Pipeline
from tb.lib.block_bench import Vectors, check_in_simulator
from tb.lib.runner import SIMULATORS

PAIR = StructLayout({"x": 8, "y": 8})
TABLE = [k * 37 % 256 for k in range(256)]
RESULT = StructLayout({"total": 10, "y": 8, "found": 8, "constant": 8})
ITEMS = [{"x": k * 5 % 256, "y": k * 91 % 256} for k in range(160)]


class Mixed(wiring.Component):
    """Ways of 0, 1 and 3 cycles that meet."""

    def __init__(self, *, stalls):
        super().__init__({"i": In(stream.Signature(PAIR, always_ready=not stalls)),
                          "o": Out(stream.Signature(RESULT, always_ready=not stalls))})
        self._memory = Memory(shape=8, depth=256, init=TABLE)
        self._port = self._memory.read_port()
        self._pipeline = p = Pipeline(self.i, self.o)
        x, y = (p.input(self.i.payload[name]) for name in "xy")
        doubled = p.register(lambda x: x << 1, x, registers=2)
        assert (doubled.age, p.combine(lambda a, b: a + b, doubled, y).age) == (2, 2)
        total = p.register(lambda a, b: a + b, doubled, y)
        p.output(self.o.payload.total, total)
        p.output(self.o.payload.y, y)
        p.output(self.o.payload.found, p.read(self._port, x))
        p.output(self.o.payload.constant, p.constant(77))
        self.latency = p.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        self._pipeline.add_to(m)
        return m


class Steps(wiring.Component):
    """How far an even number is from the number in front of it; odd ones do not come out."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(8, always_ready=True)),
                          "o": Out(stream.Signature(8, always_ready=True))})
        self._pipeline = p = Pipeline(self.i, self.o)
        x = p.delay(p.input(self.i.payload), 1)
        p.keep(p.combine(lambda x: ~x[0], x))
        p.output(self.o.payload, p.register(lambda x, before: (x - before)[:8], x, p.before(x, 1)))

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        return m


def results(items):
    return [{"total": 2 * item["x"] + item["y"], "y": item["y"], "found": TABLE[item["x"]], "constant": 77}
            for item in items]


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("stalls", [True, False])
def test_in_the_simulator(stalls, simulator):
    check_in_simulator(f"pipeline-{stalls}", lambda config: Mixed(stalls=stalls),
                       lambda config: Vectors(items=ITEMS, expected={"o": results(ITEMS)}), simulator=simulator)


def test_keep_and_before():
    steps, numbers, came = Steps(), [3, 10, 12, 15, 40, 41, 44], []

    async def drive(ctx):
        for number in [*numbers, None, None, None]:
            ctx.set(steps.i.valid, number is not None)
            ctx.set(steps.i.payload, number or 0)
            if ctx.get(steps.o.valid):
                came.append(ctx.get(steps.o.payload))
            await ctx.tick()

    simulator = Simulator(steps)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    assert came == [7, 2, 25, 3]


def test_latency_is_that_of_the_longest_path():
    assert Mixed(stalls=True).latency == 3


def test_registers_are_shared():
    pipeline = Pipeline(*(stream.Signature(4, always_ready=True).create() for _ in range(2)))
    x = pipeline.input(pipeline._i.payload)
    assert pipeline.delay(x, 2).value is pipeline.delay(pipeline.delay(x, 1), 1).value
    assert len(pipeline._delays(Module())) == 2


@pytest.mark.parametrize("stalls", [False, True])
@pytest.mark.parametrize("cycles", [5, 6, 7, 18, 19, 20, 24, 40])
def test_a_long_wait_is_as_long_in_a_memory(cycles, stalls):
    class Waits(wiring.Component):
        def __init__(self):
            super().__init__({"i": In(stream.Signature(8, always_ready=not stalls)),
                              "o": Out(stream.Signature(StructLayout({"late": signed(8), "early": 8}),
                                                        always_ready=not stalls))})
            self._pipeline = p = Pipeline(self.i, self.o)
            late = p.delay(p.combine(lambda x: x.as_signed(), p.input(self.i.payload)), cycles)
            p.output(self.o.payload.late, late)
            p.output(self.o.payload.early, p.delay(p.input(self.i.payload), 2))
            self.latency = p.latency

        def elaborate(self, platform):
            m = Module()
            self._pipeline.add_to(m)
            return m

    waits, came, random = Waits(), [], Random(cycles)
    items = [random.randrange(256) for _ in range(60)]

    async def drive(ctx):
        for item in items:
            ctx.set(waits.i.payload, item)
            ctx.set(waits.i.valid, 1)
            if stalls:
                await ctx.tick().until(waits.i.ready)
            else:
                await ctx.tick()
            ctx.set(waits.i.valid, 0)
            for _ in range(random.randrange(3)):
                await ctx.tick()

    async def take(ctx):
        while len(came) < len(items):
            if stalls:
                ctx.set(waits.o.ready, random.randrange(2))
            *_, valid, ready, late, early = await ctx.tick().sample(
                waits.o.valid, waits.o.ready, waits.o.payload.late, waits.o.payload.early)
            if valid and ready:
                came.append((late % 256, early))

    simulator = Simulator(waits)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(take)
    simulator.run()
    assert waits.latency == cycles
    assert came == [(item, item) for item in items]


@pytest.mark.parametrize(("registers", "age"), [(1, 1), (2, 2), (3, 3)])
def test_age_of_a_product(registers, age):
    pipeline = Pipeline(*(stream.Signature(4, always_ready=True).create() for _ in range(2)))
    x = pipeline.input(pipeline._i.payload)
    assert pipeline.product(x, x, registers=registers).age == age


def test_init_wrong_streams():
    waits, flows = stream.Signature(4).create(), stream.Signature(4, always_ready=True).create()
    with pytest.raises(ValueError, match=r"^Input must be a stream that can wait where the output can"):
        Pipeline(flows, waits)


def test_wrong_before():
    pipeline = Pipeline(stream.Signature(4).create(), stream.Signature(4).create())
    with pytest.raises(ValueError, match=r"^Output must be always ready for items to follow each other"):
        pipeline.before(pipeline.input(pipeline._i.payload), 1)


class Powers(wiring.Component):
    """``x^2 y``, ``-3 x y``, and x as it was one item before; x is signed."""

    def __init__(self, *, interval, registers):
        pair = StructLayout({"x": signed(8), "y": 8})
        result = StructLayout({"cube": signed(26), "scaled": signed(20), "before": signed(8)})
        super().__init__({"i": In(stream.Signature(pair, always_ready=True)),
                          "o": Out(stream.Signature(result, always_ready=True))})
        self._pipeline = p = Pipeline(self.i, self.o, interval=interval)
        x, y = (p.input(self.i.payload[name]) for name in "xy")
        square = p.product(x, x, registers=registers)
        p.output(self.o.payload.cube, p.product(p.combine(lambda value: value[:16], square), y, registers=registers))
        p.output(self.o.payload.scaled, p.product(p.product(x, y, registers=registers), p.constant(Const(-3)),
                                                  registers=registers))
        held = p.delay(x, 1)
        p.output(self.o.payload.before, p.register(lambda value: value, p.before(held, 1)))
        self.latency = p.latency
        self.multipliers = len(p._multipliers)

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        return m


@pytest.mark.parametrize("registers", [1, 2, 3])
@pytest.mark.parametrize(("interval", "multipliers"), [(1, 0), (2, 3), (5, 2), (12, 1)])
def test_items_far_apart_share_dsp_blocks(interval, multipliers, registers):
    powers, came, times = Powers(interval=interval, registers=registers), [], []
    assert powers.multipliers <= multipliers
    items = [(k * 37 % 256 - 128, k * 91 % 256) for k in range(30)]

    async def drive(ctx):
        for number, (x, y) in enumerate(items):
            ctx.set(powers.i.payload, {"x": x, "y": y})
            ctx.set(powers.i.valid, 1)
            await ctx.tick()
            # What is not an item's is nobody's.
            ctx.set(powers.i.valid, 0)
            ctx.set(powers.i.payload, {"x": 5, "y": 77})
            if interval > 1:
                await ctx.tick().repeat(interval - 1 + (number == 20) * 3)
        await ctx.tick().repeat(powers.latency + 2)

    async def watch(ctx):
        cycle = 0
        async for *_, valid, payload in ctx.tick().sample(powers.o.valid, powers.o.payload):
            cycle += 1
            if valid:
                came.append((payload.cube, payload.scaled, payload.before))
                times.append(cycle)

    simulator = Simulator(powers)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    assert [one[:2] for one in came] == [(x * x * y, -3 * x * y) for x, y in items]
    # Without a gap the one before is an interval ahead.
    for number in (*range(1, 21), *range(22, len(items))):
        assert came[number][2] == items[number - 1][0]
    assert times[0] == powers.latency + 1


def test_init_wrong_interval():
    with pytest.raises(ValueError, match=r"^Interval must be at least 1, not 0$"):
        Pipeline(stream.Signature(8).create(), stream.Signature(8).create(), interval=0)
    with pytest.raises(ValueError, match=r"^Interval must be 1 where the output can wait, not 2$"):
        Pipeline(stream.Signature(8).create(), stream.Signature(8).create(), interval=2)
