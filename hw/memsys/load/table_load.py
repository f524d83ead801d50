"""Table load: words of a memory image to the tables of a cluster."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["TableLoad"]


class TableLoad(wiring.Component):
    """Routes the words that `PreloadDma` reads to the tables of `MemorySystem`. Words of other regions are ignored.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `MemoryFormats.table_word`
        Words of this cluster. Always ready.
    o_cells : Out, stream of `PathFormats.cell_load`
        Always ready.
    o_lists : Out, stream of `PathFormats.list_load`
        Always ready.
    o_types : Out, stream of `PathFormats.type_load`
        Always ready.
    o_geometry : Out, stream of `PathFormats.geometry_load`
        Always ready.

    Timing
    ------
    Latency: ``1`` cycle. One word per cycle; never stalls.
    """

    latency = 1

    def __init__(self, *, config: Config):
        formats = PathFormats(config)
        super().__init__({
            "i": In(stream.Signature(MemoryFormats(config).table_word, always_ready=True)),
            **{f"o_{name}": Out(stream.Signature(shape, always_ready=True)) for name, shape in (
                ("cells", formats.cell_load), ("lists", formats.list_load), ("types", formats.type_load),
                ("geometry", formats.geometry_load))}})

    def elaborate(self, platform):
        m = Module()
        # Registered: a word is decoded before it goes to the tables, which are far from each other.
        word = Signal(self.i.payload.shape(), reset_less=True)
        m.d.sync += word.eq(self.i.payload)
        for region, out in ((RegionNumber.CELLS, self.o_cells), (RegionNumber.PATCH_LISTS, self.o_lists),
                            (RegionNumber.RESIDENCE, self.o_types), (RegionNumber.PATCHES, self.o_geometry)):
            # The fields of these records are in the order of their bytes.
            m.d.sync += out.valid.eq(self.i.valid & (self.i.payload.region == region))
            m.d.comb += [out.payload.address.eq(word.record), out.payload.record.eq(word.data)]
        m.d.comb += self.o_geometry.payload.word.eq(word.word)
        return m
