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
    shape, came = operator.i.payload.shape(), []

    async def drive(ctx):
        rows = [{f"_{k}": int(column[row]) for k, column in enumerate(columns)} for row in range(len(columns[0]))]
        for cycle in range((len(rows) - 1) * interval + operator.latency + 1):
            row, waits = divmod(cycle, interval)
            enters = waits == 0 and row < len(rows)
            # What is not a row's is nobody's.
            ctx.set(operator.i.payload.as_value(), pack(shape, rows[row]) if enters else (1 << shape.size) // 3)
            ctx.set(operator.i.valid, enters)
            leaves = cycle >= operator.latency and (cycle - operator.latency) % interval == 0
            assert ctx.get(operator.o.valid) == leaves
            if leaves:
                came.append(unpack(operator.o.payload.shape(), ctx.get(operator.o.payload.as_value())))
            await ctx.tick()

    simulator = Simulator(operator)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    return [[row[f"_{k}"] for row in came] for k in range(len(results))], operator.latency


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
