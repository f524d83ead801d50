"""Table check: no record points outside the table that it points into."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.pipeline import Pipeline
from hw.memsys.image_layout import RECORD_WORDS, RULES, RegionNumber, RuleKind

__all__ = ["COUNT_BITS", "TableCheck"]

COUNT_BITS = 32


class TableCheck(wiring.Component):
    """Each word of a record by the rule for it in `hw.memsys.image_layout`.

    Parameters
    ----------
    tag
        Shape of what goes along.

    Members
    -------
    i
        ``region``, ``word`` (of the record), ``data``, ``tag``; the words of a record in order.
    o
        The same, and whether it is ``bad``.
    table, limit
        Asks for the number of records of a region, in the same cycle.

    Timing
    ------
    Latency: ``4`` cycles. One word per cycle; stalls with ``o``.

    Golden counterpart: `golden.memory_map.from_bytes`.
    """

    def __init__(self, *, tag):
        word = {"region": RegionNumber, "word": range(max(RECORD_WORDS)), "data": 64, "tag": tag}
        super().__init__({"i": In(stream.Signature(StructLayout(word))),
                          "o": Out(stream.Signature(StructLayout({**word, "bad": 1}))),
                          "table": Out(RegionNumber), "limit": In(COUNT_BITS)})
        self._before, self._rule = Signal(32), Signal(StructLayout({"kind": RuleKind, "early": 1}))
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        low, high = self.i.payload.data[:32], self.i.payload.data[32:]
        early = self._rule.early
        a, b = (pipeline.delay(pipeline.input(value), 1)
                for value in (Mux(early, self._before, low), Mux(early, low, high)))
        kind, limit = (pipeline.delay(pipeline.input(value), 1) for value in (self._rule.kind.as_value(), self.limit))
        total, rises = pipeline.register(lambda a, b: (a + b, a < b), a, b)
        below, within, ends, same = pipeline.register(
            lambda a, b, total, limit: (a < limit, total <= limit, b <= limit, a == limit), a, b, total, limit)
        none = pipeline.register(lambda a: a.all(), a)
        bad = pipeline.register(
            lambda kind, below, within, ends, rises, none, same: Mux(
                kind == RuleKind.BELOW.value, ~below, Mux(kind == RuleKind.MAYBE.value, ~below & ~none, Mux(
                    kind == RuleKind.RANGE.value, ~within, Mux(kind == RuleKind.SPAN.value, ~(rises & ends), Mux(
                        kind == RuleKind.SAME.value, ~same, 0))))),
            kind, below, within, ends, rises, none, same)
        for name in "region", "word", "data", "tag":
            pipeline.output(self.o.payload[name], pipeline.input(self.i.payload[name]))
        pipeline.output(self.o.payload.bad, bad)
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        given, rule = self.i.payload, self._rule
        for one in RULES:
            with m.If((given.region == RegionNumber(one.region)) & (given.word == one.word)):
                m.d.comb += [rule.kind.eq(one.kind), rule.early.eq(one.early),
                             self.table.eq(RegionNumber(one.table))]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += self._before.eq(given.data[32:])
        self._pipeline.add_to(m)
        return m
