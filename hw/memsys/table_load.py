"""Table load: the words of a memory image to the tables of a cluster."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.image_layout import RegionNumber
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import PathFormats

__all__ = ["TableLoad"]


class TableLoad(wiring.Component):
    """Gives `hw.memsys.memory_system.MemorySystem` what it loads, of what `hw.memsys.preload_dma.PreloadDma` reads.
    Words of other regions are for others.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``region``, ``record``, ``word`` and ``data``. Always ready.
    o_cells, o_lists, o_types, o_geometry
        `PathFormats.cell_load`, ``list_load``, ``type_load`` and ``geometry_load``. Always ready.

    Timing
    ------
    Latency: ``0`` cycles. One word per cycle; nothing stalls.
    """

    latency = 0

    def __init__(self, *, config: Config):
        formats = PathFormats(config)
        super().__init__({
            "i": In(stream.Signature(MemoryFormats(config).table_word, always_ready=True)),
            **{f"o_{name}": Out(stream.Signature(shape, always_ready=True)) for name, shape in (
                ("cells", formats.cell_load), ("lists", formats.list_load), ("types", formats.type_load),
                ("geometry", formats.geometry_load))}})

    def elaborate(self, platform):
        m = Module()
        word = self.i.payload
        for region, out in ((RegionNumber.CELLS, self.o_cells), (RegionNumber.PATCH_LISTS, self.o_lists),
                            (RegionNumber.RESIDENCE, self.o_types), (RegionNumber.PATCHES, self.o_geometry)):
            # The fields of these records are in the order of their bytes.
            m.d.comb += [out.valid.eq(self.i.valid & (word.region == region)), out.payload.address.eq(word.record),
                         out.payload.record.eq(word.data)]
        m.d.comb += self.o_geometry.payload.word.eq(word.word)
        return m
