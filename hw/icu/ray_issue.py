"""Ray issue: the rays of a tile that may still improve, one per cycle."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats

__all__ = ["RayIssue"]


class RayIssue(wiring.Component):
    """Takes the rays out of the masks that the window walk found, lowest first.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        `Formats.tile_rays`.
    o
        `Formats.issued`. Always ready.
    first_column, first_row
        Of the section; the same while rays are under way.

    Timing
    ------
    Latency: ``3`` cycles. A mask of n rays takes max(n, 1) cycles, without a gap to the next one; nothing else stalls.

    Golden counterpart: `golden.icu.window_walk.window_rays`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, Formats(config)
        super().__init__({"i": In(stream.Signature(self._formats.tile_rays)),
                          "o": Out(stream.Signature(self._formats.issued, always_ready=True)),
                          "first_column": In(self._formats.count), "first_row": In(self._formats.count)})
        self.latency = 3

    def elaborate(self, platform):
        m = Module()
        side = self._config.icu.tile_bits
        lanes = 1 << 2 * side
        now, there = Signal(self._formats.tile_rays), Signal()
        def without_lowest(mask):
            return mask & (mask - 1)[:lanes]

        # The last ray of a tile, or none, known a cycle before: it lets the next tile in.
        rest, ends = without_lowest(now.mask), Signal()
        m.d.comb += self.i.ready.eq(~there | ends)
        m.d.sync += [now.mask.eq(rest), ends.eq(~without_lowest(rest).any())]
        with m.If(self.i.ready):
            m.d.sync += [now.eq(self.i.payload), there.eq(self.i.valid),
                         ends.eq(~without_lowest(self.i.payload.mask).any())]

        lowest = Signal(lanes)
        m.d.comb += lowest.eq(now.mask & ~rest)
        lane = Cat(Cat(lowest[k] for k in range(lanes) if k >> bit & 1).any() for bit in range(2 * side))
        first, valid = Signal(self._formats.issued), Signal()
        m.d.sync += [valid.eq(there), first.slot.eq(now.slot), first.is_ray.eq(now.mask.any()),
                     first.last.eq(now.last & ends), first.ray.eq(Cat(lane, now.tile)),
                     first.column.eq(Cat(lane[:side], now.tile_column)), first.row.eq(Cat(lane[side:], now.tile_row))]
        m.d.sync += [self.o.valid.eq(valid), self.o.payload.eq(first),
                     self.o.payload.column.eq(first.column + self.first_column),
                     self.o.payload.row.eq(first.row + self.first_row)]
        return m
