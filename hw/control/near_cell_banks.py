"""Near cell banks: the cells of shell 1 of a section and of the next one."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.job_formats import JobFormats
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.pipeline import Pipeline

__all__ = ["NearCellBanks"]


class NearCellBanks(wiring.Component):
    """Stores the cells of shell 1 in two banks, two cells a word, and sends those of one bank for each section.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of `JobFormats.near_pair`
        Two cells by the number of their word. Always ready; not of the bank that is being sent.
    i : In, stream of ``bank``, ``count``
        The bank, and how many of its cells to send. Accepted when the previous ones have left.
    o : Out, stream of `CtuFormats.near_cell`
        The cells; of none, one item that is no cell.

    Timing
    ------
    Latency: ``3`` cycles. One cell per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.ctu.near_cells`.
    """

    def __init__(self, *, config: Config):
        self._formats, bits = CtuFormats(config), config.ctu.near_cell_bits
        self._bits, cell = bits, self._formats.cell
        super().__init__({
            "i_load": In(stream.Signature(JobFormats(config).near_pair, always_ready=True)),
            "i": In(stream.Signature(StructLayout({"bank": 1, "count": bits + 1}))),
            "o": Out(stream.Signature(self._formats.near_cell))})
        self._memory = Memory(shape=2 * cell.width, depth=1 << bits, init=[])
        self._steps = stream.Signature(StructLayout({"bank": 1, "address": bits, "is_cell": 1, "last": 1})).create()
        self._pipeline = pipeline = Pipeline(self._steps, self.o)
        step = self._steps.payload
        pair = pipeline.read(self._memory.read_port(), pipeline.input(Cat(step.address[1:], step.bank)))
        pipeline.output(self.o.payload.cell, pipeline.register(
            lambda pair, is_odd: Mux(is_odd, pair[cell.width:], pair[:cell.width]), pair,
            pipeline.input(step.address[0])))
        for name in "is_cell", "last":
            pipeline.output(self.o.payload[name], pipeline.input(step[name]))
        self.latency = 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        write, load, steps = self._memory.write_port(), self.i_load, self._steps
        m.d.comb += [write.addr.eq(Cat(load.payload.address, load.payload.bank)), write.data.eq(load.payload.cells),
                     write.en.eq(load.valid)]
        self._pipeline.add_to(m)
        busy, address, left, is_cell, bank = Signal(), Signal(self._bits), Signal(self._bits + 1), Signal(), Signal()
        m.d.comb += [
            self.i.ready.eq(~busy), steps.valid.eq(busy), steps.payload.bank.eq(bank),
            steps.payload.address.eq(address), steps.payload.is_cell.eq(is_cell), steps.payload.last.eq(left == 1)]
        with m.If(busy & steps.ready):
            m.d.sync += [address.eq(address + 1), left.eq(left - 1), busy.eq(left != 1)]
        count = self.i.payload["count"]
        with m.If(self.i.valid & ~busy):
            m.d.sync += [busy.eq(1), address.eq(0), bank.eq(self.i.payload.bank), is_cell.eq(count != 0),
                         left.eq(Mux(count == 0, 1, count))]
        return m
