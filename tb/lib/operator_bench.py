"""The bench of an operator of pipelines."""

from collections.abc import Callable, Sequence

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hw.lib.pipeline import Pipeline
from tb.lib.payload import pack, unpack

__all__ = ["run_operator"]


def run_operator(operands: Sequence, results: Sequence, apply: Callable, columns: Sequence) -> tuple[list, int]:
    """What an operator of pipelines makes of rows of operands, one per cycle, in Amaranth's own simulator.

    Parameters
    ----------
    operands, results
        Shapes.
    apply
        From the pipeline and the staged operands to the list of staged results.
    columns
        Values of each operand.

    Returns
    -------
    Values of each result, and the latency.
    """
    operator = _Operator(operands, results, apply)
    shape, came = operator.i.payload.shape(), []

    async def drive(ctx):
        for cycle in range(len(columns[0]) + operator.latency):
            if cycle < len(columns[0]):
                row = {f"_{k}": int(column[cycle]) for k, column in enumerate(columns)}
                ctx.set(operator.i.payload.as_value(), pack(shape, row))
            ctx.set(operator.i.valid, cycle < len(columns[0]))
            assert ctx.get(operator.o.valid) == (cycle >= operator.latency)
            if cycle >= operator.latency:
                came.append(unpack(operator.o.payload.shape(), ctx.get(operator.o.payload.as_value())))
            await ctx.tick()

    simulator = Simulator(operator)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    return [[row[f"_{k}"] for row in came] for k in range(len(results))], operator.latency


class _Operator(wiring.Component):
    """An operator between two streams."""

    def __init__(self, operands, results, apply):
        operands, results = (StructLayout({f"_{k}": shape for k, shape in enumerate(shapes)})
                             for shapes in (operands, results))
        super().__init__({"i": In(stream.Signature(operands, always_ready=True)),
                          "o": Out(stream.Signature(results, always_ready=True))})
        self._pipeline = Pipeline(self.i, self.o)
        values = [self._pipeline.input(self.i.payload[name]) for name, _ in operands]
        for (name, _), value in zip(results, apply(self._pipeline, *values), strict=True):
            self._pipeline.output(self.o.payload[name], value)
        self.latency = self._pipeline.latency

    def elaborate(self, platform):
        """The pipeline."""
        m = Module()
        self._pipeline.add_to(m)
        return m
