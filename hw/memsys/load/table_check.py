"""Table check: no record points outside its table, and no number is too large for the machine."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memory_map import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, WEIGHT_BITS
from hw.lib.pipeline import Pipeline
from hw.memsys.load.image_layout import COUNT_BITS, KIND_BYTE, RULES, RegionNumber, RuleKind
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["TableCheck"]


class TableCheck(wiring.Component):
    """Checks each word of a record by its rule in `hw.memsys.load.image_layout`.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of a sideband value.

    Members
    -------
    i : In, stream of ``item`` (`MemoryFormats.table_word`), ``tag``
        The words of each record in order.
    o : Out, stream of ``item``, ``tag``, ``fault`` (`Fault`)
        The same words; the fault is ``NONE``, ``POINTER`` or ``SIZE``.
    table : Out(RegionNumber)
        The region that the word at ``i`` points into.
    limit : In(COUNT_BITS)
        Records of that region, in the same cycle.

    Timing
    ------
    Latency: ``4`` cycles. One word per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.memory_map.check.check_image`.
    """

    def __init__(self, *, config: Config, tag):
        word = {"item": MemoryFormats(config).table_word, "tag": tag}
        super().__init__({"i": In(stream.Signature(StructLayout(word))),
                          "o": Out(stream.Signature(StructLayout({**word, "fault": Fault}))),
                          "table": Out(RegionNumber), "limit": In(COUNT_BITS)})
        # High halves of the last word and of the one before it.
        self._previous = [Signal(32, name=f"previous_{age}") for age in (1, 2)]
        self._rule = Signal(StructLayout({"kind": RuleKind, "early": 1}))
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        given, early = self.i.payload.item, self._rule.early
        low, high = given.data[:32], given.data[32:]
        a, b = (pipeline.delay(pipeline.input(value), 1)
                for value in (Mux(early, self._previous[0], low), Mux(early, low, high)))
        kind, limit = (pipeline.delay(pipeline.input(value), 1) for value in (self._rule.kind.as_value(), self.limit))
        total = pipeline.register(lambda a, b: a + b, a, b)
        below, within = pipeline.register(
            lambda a, total, limit: (a < limit, total <= limit), a, total, limit)
        none = pipeline.register(lambda a: a[1:].all(), a)
        breaks = pipeline.combine(
            lambda kind, below, within, none: Mux(
                kind == RuleKind.BELOW.value, ~below, Mux(kind == RuleKind.MAYBE.value, ~below & ~none, Mux(
                    kind == RuleKind.RANGE.value, ~within, 0))),
            kind, below, within, none)
        shape, weight, other = pipeline.register(lambda a, b: (
            (a >> GRID_SHAPE_BITS).any() | (b >> GRID_SHAPE_BITS).any(), b >> WEIGHT_BITS - 32 != 0,
            Cat(a, b).word_select(KIND_BYTE, 8) != 0), a, b)
        exceeds = pipeline.combine(
            lambda kind, shape, grid, weight, other: Mux(kind == RuleKind.SMALL.value, shape, Mux(
                kind == RuleKind.GRID.value, grid, Mux(kind == RuleKind.WEIGHT.value, weight, Mux(
                    kind == RuleKind.QUAD.value, other, 0)))),
            kind, shape, self._add_grid_rays(pipeline, a), weight, other)
        fault = pipeline.register(lambda breaks, exceeds: Mux(
            breaks, Const(Fault.POINTER.value, 4), Mux(exceeds, Const(Fault.SIZE.value, 4), 0)), breaks, exceeds)
        for name in "item", "tag":
            pipeline.output(self.o.payload[name], pipeline.input(self.i.payload[name]))
        pipeline.output(self.o.payload.fault, fault)
        self.latency = pipeline.latency

    def _add_grid_rays(self, pipeline, first_ray):
        """Whether a shell has too many grid rays: its rows and columns are in the two words before its first ray."""
        columns, rows = (pipeline.input(value) for value in self._previous)
        rays = pipeline.product(pipeline.combine(lambda columns: columns[:GRID_SIDE_BITS], columns),
                                pipeline.combine(lambda rows: rows[:GRID_SIDE_BITS], rows), registers=2)
        wide = pipeline.register(lambda columns, rows: (columns | rows) >> GRID_SIDE_BITS != 0, columns, rows)
        total = pipeline.register(lambda rays, first_ray: rays + first_ray, rays, first_ray)
        return pipeline.combine(lambda total, wide: wide | (total > 1 << GRID_RAY_BITS), total, wide)

    def elaborate(self, platform):
        m = Module()
        given, rule = self.i.payload.item, self._rule
        for one in RULES:
            with m.If((given.region == RegionNumber(one.region)) & (given.word == one.word)):
                m.d.comb += [rule.kind.eq(one.kind), rule.early.eq(one.early),
                             self.table.eq(RegionNumber(one.table))]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [self._previous[0].eq(given.data[32:]), self._previous[1].eq(self._previous[0])]
        self._pipeline.add_to(m)
        return m
