"""The cell address table: where the patch list of each cell begins and how long it is."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["CellTable"]


class CellTable(wiring.Component):
    """Looks up the lists of the cells that have a record here: the first ``own_cells`` of the scene.

    Whether a list is within the patch lists, and whether all of it is in the patch table, is checked when the record is
    loaded.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of `PathFormats.cell_load`
        Records in any order. Always ready; not while cells are in flight. Other addresses are ignored.
    lists : In(32)
        Entries of the scene's patch lists. Stable while records are loaded.
    i : In, stream of the number of a cell
        Cells.
    o : Out, stream of `PathFormats.found_cell`
        The same cells with their lists.

    Timing
    ------
    Latency: ``2`` cycles; ``3`` of a load. One cell per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.memsys.patches.cell_table.CellTable`. Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        formats, memsys = self._formats, config.memsys
        super().__init__({
            "i_load": In(stream.Signature(formats.cell_load, always_ready=True)),
            "lists": In(formats.scene["lists"].shape), "i": In(stream.Signature(formats.cell_bits)),
            "o": Out(stream.Signature(formats.found_cell))})
        self._row = StructLayout({"list": formats.list_extent, "is_own": 1, "is_empty": 1, "wrong": 1})
        self._memory = Memory(shape=self._row, depth=memsys.own_cells, init=[], attrs={"no_rw_check": 1})
        self._address_bits = memsys.own_cells.bit_length() - 1
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        cell = pipeline.input(self.i.payload)
        # A register behind the block RAM.
        row = pipeline.delay(pipeline.read(self._memory.read_port(), pipeline.combine(
            lambda cell: cell[:self._address_bits], cell)), 1)
        here = pipeline.combine(lambda cell: cell[self._address_bits:] == 0, cell)
        pipeline.output(self.o.payload.cell, cell)
        pipeline.output(self.o.payload.list, pipeline.combine(lambda row: row.list, row))
        for name in "is_own", "is_empty", "wrong":
            pipeline.output(self.o.payload[name], pipeline.combine(
                lambda row, here, name=name: row[name] & here, row, here))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        self._pipeline.add_to(m)
        given, write = self.i_load.payload, self._memory.write_port()
        end = Signal(len(given.record.pointer) + 1, reset_less=True)
        first, comes = Signal.like(given, reset_less=True), Signal()
        m.d.sync += [
            comes.eq(self.i_load.valid), first.eq(given), end.eq(given.record.pointer + given.record.count),
            write.en.eq(comes & (first.address[self._address_bits:] == 0)),
            write.addr.eq(first.address), write.data.list.pointer.eq(first.record.pointer),
            write.data.list.count.eq(first.record.count), write.data.is_own.eq(end <= self._config.memsys.own_entries),
            write.data.is_empty.eq(first.record.count == 0), write.data.wrong.eq(end > self.lists)]
        return m
