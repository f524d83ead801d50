"""The testbench of an operator of pipelines."""

from collections.abc import Callable, Sequence

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.pipeline import Pipeline
from tb.lib.schedules import Schedule, ScheduleBench

__all__ = ["run_operator"]


def run_operator(operands: Sequence, results: Sequence, apply: Callable, columns: Sequence, *,
                 interval: int = 1) -> tuple[list, int]:
    """What an operator of pipelines makes of rows of operands in Amaranth's own simulator.

    Parameters
    ----------
    operands, results
        Shapes.
    apply
        From the pipeline and the staged operands to the list of staged results.
    columns
        Values of each operand.
    interval
        Cycles from a row to the next one.

    Returns
    -------
    Values of each result, and the latency.
    """
    operator = _Operator(operands, results, apply, interval)
    rows = [{f"_{k}": int(column[row]) for k, column in enumerate(columns)} for row in range(len(columns[0]))]
    bench = ScheduleBench(operator, idle_limit=operator.latency + interval + 2, watchdog=100_000)
    came = bench.run(Schedule(items={"i": [((interval - 1) * (number > 0), row) for number, row in enumerate(rows)]}))
    assert [b - a for a, b in zip(bench.cycles["i"], bench.cycles["o"], strict=True)] == [operator.latency] * len(rows)
    return [[row[f"_{k}"] for row in came["o"]] for k in range(len(results))], operator.latency


class _Operator(wiring.Component):
    """An operator between two streams."""

    def __init__(self, operands, results, apply, interval):
        operands, results = (StructLayout({f"_{k}": shape for k, shape in enumerate(shapes)})
                             for shapes in (operands, results))
        super().__init__({"i": In(stream.Signature(operands, always_ready=True)),
                          "o": Out(stream.Signature(results, always_ready=True))})
        self._pipeline = Pipeline(self.i, self.o, interval=interval)
        values = [self._pipeline.input(self.i.payload[name]) for name, _ in operands]
        for (name, _), value in zip(results, apply(self._pipeline, *values), strict=True):
            self._pipeline.output(self.o.payload[name], value)
        self.latency = self._pipeline.latency

    def elaborate(self, platform):
        """The pipeline."""
        m = Module()
        self._pipeline.add_to(m)
        return m
