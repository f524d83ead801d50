"""Ray issue: the rays of a tile that may still improve, one per cycle."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats

__all__ = ["RayIssue"]


class RayIssue(wiring.Component):
    """Issues the rays of the masks that the window walk found, lowest first.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `IcuFormats.tile_rays`
        Masks of tiles.
    o : Out, stream of `IcuFormats.issued`, always ready
        One ray after the other.
    first_column, first_row : In, `Formats.count`
        Of the section; stable while rays are in flight.

    Timing
    ------
    Latency: ``4`` cycles. A mask of n rays takes max(n, 1) cycles, without a gap to the next one; nothing else stalls.

    Golden counterpart: `golden.engine.icu.window_walk.window_rays`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        super().__init__({"i": In(stream.Signature(self._formats.tile_rays)),
                          "o": Out(stream.Signature(self._formats.issued, always_ready=True)),
                          "first_column": In(self._formats.count), "first_row": In(self._formats.count)})
        self.latency = 4

    def elaborate(self, platform):
        m = Module()
        side = self._config.icu.tile_bits
        lanes = 1 << 2 * side
        following, waits = Signal(self._formats.tile_rays), Signal()
        now, there = Signal(self._formats.tile_rays), Signal()
        # The last ray of a tile, or none, known a cycle before: it lets the next tile in.
        rest, ends = now.mask & (now.mask - 1)[:lanes], Signal()
        # Registers for what enables so many: the present tile ends or there is none, and the waiting one does not stay.
        takes, ready = Signal(init=1), Signal(init=1)
        ends_next, takes_next = ~_at_least(now.mask)[2], Signal()
        m.d.comb += [self.i.ready.eq(ready), takes_next.eq(ends_next)]
        with m.If(ready):
            m.d.sync += [following.eq(self.i.payload), waits.eq(self.i.valid)]
        m.d.sync += [now.mask.eq(rest), ends.eq(ends_next)]
        with m.If(takes):
            ends_next = ~_at_least(following.mask)[1]
            m.d.comb += takes_next.eq(~waits | ends_next)
            m.d.sync += [now.eq(following), there.eq(waits), ends.eq(ends_next)]
        m.d.sync += [takes.eq(takes_next), ready.eq(takes_next | (ready & ~self.i.valid))]

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


def _at_least(mask):
    """Whether a mask has one bit at least, two, and three."""
    if len(mask) == 1:
        return mask, Const(0, 1), Const(0, 1)
    (a1, a2, a3), (b1, b2, b3) = _at_least(mask[:len(mask) // 2]), _at_least(mask[len(mask) // 2:])
    return a1 | b1, a2 | b2 | (a1 & b1), a3 | b3 | (a2 & b1) | (a1 & b2)
