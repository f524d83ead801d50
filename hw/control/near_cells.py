"""Near cells: the cells of shell 1 of a frustum."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.pipeline import Pipeline

__all__ = ["NearCells"]


class NearCells(wiring.Component):
    """Stores the cells of shell 1, and sends all of them for each frustum.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of ``address``, ``cell``
        Cells by index. Always ready.
    i : In, stream of a number of cells
        How many to send. Accepted when the previous ones have left.
    o : Out, stream of `CtuFormats.near_cell`
        The cells; of none, one item that is no cell.

    Timing
    ------
    Latency: ``3`` cycles. One cell per cycle; stalls with ``o``.

    Golden counterpart: `golden.ctu.near_cells`.
    """

    def __init__(self, *, config: Config):
        self._formats, self._bits = CtuFormats(config), config.ctu.near_cell_bits
        formats = self._formats
        super().__init__({
            "i_load": In(stream.Signature(StructLayout({"address": self._bits, "cell": formats.cell}),
                                          always_ready=True)),
            "i": In(stream.Signature(self._bits + 1)), "o": Out(stream.Signature(formats.near_cell))})
        self._memory = Memory(shape=formats.cell, depth=1 << self._bits, init=[])
        self._steps = stream.Signature(StructLayout({"address": self._bits, "is_cell": 1, "last": 1})).create()
        self._pipeline = pipeline = Pipeline(self._steps, self.o)
        step = self._steps.payload
        pipeline.output(self.o.payload.cell, pipeline.delay(
            pipeline.read(self._memory.read_port(), pipeline.input(step.address)), 1))
        for name in "is_cell", "last":
            pipeline.output(self.o.payload[name], pipeline.input(step[name]))
        self.latency = 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        write, load, steps = self._memory.write_port(), self.i_load, self._steps
        m.d.comb += [write.addr.eq(load.payload.address), write.data.eq(load.payload.cell), write.en.eq(load.valid)]
        self._pipeline.add_to(m)
        busy, address, left, is_cell = Signal(), Signal(self._bits), Signal(self._bits + 1), Signal()
        m.d.comb += [
            self.i.ready.eq(~busy), steps.valid.eq(busy), steps.payload.address.eq(address),
            steps.payload.is_cell.eq(is_cell), steps.payload.last.eq(left == 1)]
        with m.If(busy & steps.ready):
            m.d.sync += [address.eq(address + 1), left.eq(left - 1), busy.eq(left != 1)]
        with m.If(self.i.valid & ~busy):
            m.d.sync += [busy.eq(1), address.eq(0), is_cell.eq(self.i.payload != 0),
                         left.eq(Mux(self.i.payload == 0, 1, self.i.payload))]
        return m
