from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.generations import Generations
from tb.lib.bench import Bench

DEPTH = 5


class Tagged(wiring.Component):
    """A memory with tags as their user keeps them: a write gives a row the current one."""

    __doc__ = Generations.__doc__

    def __init__(self, *, bits):
        self._generations = Generations(bits=bits, depth=DEPTH)
        self._tags = Memory(shape=bits, depth=DEPTH, init=[])
        self.latency = self._generations.latency
        members = dict(self._generations.signature.members.items())
        super().__init__({**members, "i_start": In(stream.Signature(0)), "write": In(1), "address": In(range(DEPTH)),
                          "holds": Out(ArrayLayout(1, DEPTH))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.generations, m.submodules.tags = generations, tags = self._generations, self._tags
        wiring.connect(m, wiring.flipped(self.i_start), generations.i_start)
        m.d.comb += [*(getattr(generations, name).eq(getattr(self, name)) for name in ("rows", "idle", "busy")),
                     *(getattr(self, name).eq(getattr(generations, name)) for name in ("generation", "sweeps", "row"))]
        port = tags.write_port()
        m.d.comb += [port.addr.eq(self.address), port.data.eq(generations.generation), port.en.eq(self.write)]
        with m.If(generations.sweeps):
            m.d.comb += [port.addr.eq(generations.row), port.data.eq(0), port.en.eq(1)]
        for row in range(DEPTH):
            read = tags.read_port(domain="comb")
            m.d.comb += [read.addr.eq(row), self.holds[row].eq(read.data == generations.generation)]
        return m


class TestGenerations(Bench):
    """Every generation begins empty, and keeps what it is given, while a sweep goes on beside it."""

    component, arguments, variants, span = Tagged, {"bits": 2}, ({},), 200
    # Each part begins with what the one before has left in the memory.
    chances = Bench.chances * 3

    def model(self, config):
        """A sweep when tags run out, in cycles without an access; a generation waits for its own rows alone."""
        last = (1 << self.arguments["bits"]) - 1
        swept, generation, self.used, self.held = 0, last, 0, None
        there = set()
        given = yield
        while True:
            self.held = given.rows if given.i_start is not None else None
            runs_out, starts = generation == last, given.i_start is not None
            sweeps = swept < DEPTH and not given.busy and (not runs_out or given.idle or starts)
            ready = swept >= given.rows
            self.used = 0 if given.idle or starts else self.used
            outputs = {"i_start": ready, "generation": generation, "sweeps": sweeps, "row": swept if sweeps else None,
                       "holds": [int(row in there) if row < self.used else None for row in range(DEPTH)]}
            if given.write:
                there.add(given.address)
            swept += sweeps
            if starts and ready:
                generation = generation % last + 1
                self.used, self.held = given.rows, None
                there.clear()
                swept = 0 if generation == last else swept
            given = yield outputs

    def items(self, name, shape, random):
        """Generations now and then."""
        while True:
            yield 0 if random.random() < 0.4 else None

    def drive(self, given, random):
        """The rows of a generation that waits stay; what is used alone is written."""
        given.rows = random.randint(0, DEPTH) if self.held is None else self.held
        given.idle = random.random() < 0.1
        given.busy = random.random() < 0.5
        is_used = self.used > 0 and not given.idle and given.i_start is None
        given.write = given.busy and is_used and random.random() < 0.8
        given.address = random.randrange(self.used) if self.used else 0


class TestOneTag(TestGenerations):
    arguments = {"bits": 1}
    constant, test_in_the_simulator = ("generation",), None
