"""Patch decoder: head and vertices of a patch from the words of its record."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memory_map import COORDINATE_BITS
from hw.formats import Formats
from hw.memsys.load.image_layout import PATCH_WORDS, WORD_BITS

__all__ = ["PatchDecoder"]

# Word 0: id and surface. Word 1: bits 64 to 71 of each beat. The others: the low bits of a vertex each.
TOPS, FIRST_VERTEX, TOP_BITS = 1, 2, 8


class PatchDecoder(wiring.Component):
    """Decodes the words of `golden.engine.memory_map`'s region ``patches``.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    valid : In(1)
        There is a word.
    word : In(range(PATCH_WORDS))
        Its number; the words of a record follow each other in order.
    data : In(64)
        The word.
    patch, surface : Out(32)
        Of word 0.
    index : Out(2)
        The number of the vertex of words 2 to 5.
    vertex : Out(Formats.scene_vector)
        That vertex.

    Timing
    ------
    Latency: ``0`` cycles. One word per cycle; never stalls.

    Golden counterpart: `golden.engine.memory_map.unpack_beats`.
    """

    latency = 0

    def __init__(self, *, config: Config):
        super().__init__({
            "word": In(range(PATCH_WORDS)), "data": In(WORD_BITS), "valid": In(1), "patch": Out(32),
            "surface": Out(32), "index": Out(2), "vertex": Out(Formats(config).scene_vector)})

    def elaborate(self, platform):
        m = Module()
        tops = Signal(WORD_BITS, reset_less=True)
        with m.If(self.valid & (self.word == TOPS)):
            m.d.sync += tops.eq(self.data)
        m.d.comb += [self.index.eq(self.word - FIRST_VERTEX), self.patch.eq(self.data),
                     self.surface.eq(self.data >> len(self.patch))]
        beat = Cat(self.data, tops.word_select(self.index + 1, TOP_BITS))
        for axis in range(3):
            m.d.comb += self.vertex[axis].eq(beat.word_select(axis, COORDINATE_BITS))
        return m
