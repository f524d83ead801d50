from random import Random

import pytest
from amaranth.hdl import Const, Module, signed
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import Elastic, Rigid

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


class Buffered(wiring.Component):
    """`Mixed` in front of a skid buffer, so that a register enables its registers."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(PAIR)), "o": Out(stream.Signature(RESULT))})
        self._skid = skid = SkidBuffer(RESULT)
        self._pipeline = p = Pipeline(self.i, skid.i, ready_next=skid.ready_next)
        x, y = (p.input(self.i.payload[name]) for name in "xy")
        table = Memory(shape=8, depth=256, init=TABLE)
        self._memory = table
        p.output(skid.i.payload.total, p.register(lambda x, y: 2 * x + y, p.delay(x, 2), y))
        p.output(skid.i.payload.y, y)
        p.output(skid.i.payload.found, p.read(table.read_port(), x))
        p.output(skid.i.payload.constant, p.constant(77))
        self.latency = p.latency + skid.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory, m.submodules.skid = self._memory, self._skid
        self._pipeline.add_to(m)
        wiring.connect(m, self._skid.o, wiring.flipped(self.o))
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


class TestMixed(Bench):
    variants, stalls = ({},), True

    def make(self, config):
        return Mixed(stalls=self.stalls)

    def latency(self, component, config):
        return component.latency

    def stages(self, component, config):
        return [Rigid(component.latency)] if self.stalls else [Elastic(component.latency)]

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": results(ITEMS)})


class TestMixedWithoutStalls(TestMixed):
    stalls = False


class TestBuffered(TestMixed):
    """The register that enables all others is what logic in its place would be: no item is lost and none waits."""

    def make(self, config):
        return Buffered()

    def stages(self, component, config):
        return [Rigid(component.latency - 1), Elastic(1, 2)]


def test_keep_and_before():
    bench = ScheduleBench(Steps())
    assert bench.run(Schedule(items={"i": [(0, number) for number in (3, 10, 12, 15, 40, 41, 44)]})) == {
        "o": [7, 2, 25, 3]}


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

    waits, random = Waits(), Random(cycles)
    items = [random.randrange(256) for _ in range(60)]
    came = ScheduleBench(waits, idle_limit=cycles + 4).run(Schedule(
        items={"i": [(random.randrange(3), item) for item in items]},
        stalls={"o": [random.randrange(2) for _ in items]}))["o"]
    assert waits.latency == cycles
    assert [(one["late"] % 256, one["early"]) for one in came] == [(item, item) for item in items]


@pytest.mark.parametrize(("registers", "age"), [(1, 1), (2, 2), (3, 3)])
def test_age_of_a_product(registers, age):
    pipeline = Pipeline(*(stream.Signature(4, always_ready=True).create() for _ in range(2)))
    x = pipeline.input(pipeline._i.payload)
    assert pipeline.product(x, x, registers=registers).age == age


def test_init_wrong_streams():
    waits, flows = stream.Signature(4).create(), stream.Signature(4, always_ready=True).create()
    with pytest.raises(ValueError, match=r"^Input must be a stream that can wait where the output can"):
        Pipeline(flows, waits)
    with pytest.raises(ValueError, match=r"^Next cycle's ready is of an output that can wait, not of one that is"):
        Pipeline(waits, flows, ready_next=Const(1))


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
    powers = Powers(interval=interval, registers=registers)
    assert powers.multipliers <= multipliers
    items = [{"x": k * 37 % 256 - 128, "y": k * 91 % 256} for k in range(30)]
    bench = ScheduleBench(powers, idle_limit=powers.latency + interval + 4)
    came = bench.run(Schedule(items={"i": [((interval - 1) * (k > 0) + (k == 21) * (interval > 1) * 3, item)
                                           for k, item in enumerate(items)]}))["o"]
    assert [(one["cube"], one["scaled"]) for one in came] == [
        (item["x"] * item["x"] * item["y"], -3 * item["x"] * item["y"]) for item in items]
    # Without a gap the one before is an interval ahead.
    for number in (*range(1, 21), *range(22, len(items))):
        assert came[number]["before"] == items[number - 1]["x"]
    assert bench.cycles["o"][0] - bench.cycles["i"][0] == powers.latency


def test_init_wrong_interval():
    with pytest.raises(ValueError, match=r"^Interval must be at least 1, not 0$"):
        Pipeline(stream.Signature(8).create(), stream.Signature(8).create(), interval=0)
    with pytest.raises(ValueError, match=r"^Interval must be 1 where the output can wait, not 2$"):
        Pipeline(stream.Signature(8).create(), stream.Signature(8).create(), interval=2)
