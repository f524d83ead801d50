"""Position search: how many rows or columns of grid rays lie before a position among the rays."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.ctu.ctu_formats import CtuFormats

__all__ = ["PositionSearch"]


class PositionSearch(wiring.Component):
    """The numbers n with ``position[first + n - 1] < bound <= position[first + n]`` of two bounds, bit by bit from the
    highest on.

    Both searches circulate in a ring of three stages: address, memory, comparison. The next addresses for both outcomes
    are computed before the comparison.

    Parameters
    ----------
    formats
        `Formats` of the configuration.
    address
        Shape of an address of the table.

    Members
    -------
    i_write : In, stream of ``address``, ``position``
        An entry of the table. Always ready; not during a search.
    i : In, stream of ``first``, ``count``, ``low``, ``end``
        The part of the table, in which positions never fall, and the two bounds.
    o : Out, stream of ``low``, ``end``
        For each bound ``count``, the number of positions below it; it is the same for all bounds from ``least`` to
        ``most``.

    Timing
    ------
    Latency: ``3 * bits(count) + 4`` cycles, ``bits(n)`` those of the number n. One search at a time.

    Golden counterpart: `golden.engine.ctu.sector`, which compares all positions.
    """

    def __init__(self, *, formats: CtuFormats, address):
        self._formats, self._address, bound = formats, address, formats.position_bound
        side = formats.grid_side
        found = StructLayout({"count": side, "least": bound, "most": bound})
        super().__init__({
            "i_write": In(stream.Signature(StructLayout({"address": address, "position": formats.position}),
                                           always_ready=True)),
            "i": In(stream.Signature(StructLayout({"first": address, "count": side, "low": bound,
                                                   "end": bound}))),
            "o": Out(stream.Signature(StructLayout({"low": found, "end": found})))})

    def elaborate(self, platform):
        m = Module()
        formats, shape = self._formats, self._address
        bits = formats.grid_side.width
        m.submodules.positions = positions = Memory(shape=formats.position, depth=1 << shape.width, init=[])
        write, read = positions.write_port(), positions.read_port()
        m.d.comb += [write.addr.eq(self.i_write.payload.address), write.data.eq(self.i_write.payload.position),
                     write.en.eq(self.i_write.valid)]

        given, starts = Signal(self.i.payload.shape(), reset_less=True), Signal(2)
        busy = Signal()
        m.d.comb += self.i.ready.eq(~busy & ~self.o.valid)
        m.d.sync += starts.eq(Cat(self.i.valid & self.i.ready, starts[0]))
        # The address before the first one, which counting from 1 begins at, and the first step.
        before, highest = Signal(shape, reset_less=True), Signal(bits, reset_less=True)
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [given.eq(self.i.payload), busy.eq(1), before.eq(self.i.payload.first - 1), highest.eq(1)]
            for bit in range(1, bits):
                with m.If(self.i.payload.count[bit]):
                    m.d.sync += highest.eq(1 << bit)

        # ``found`` positions are less, and of those up to ``step`` more the last one is looked at, if it is there.
        search = StructLayout({"found": bits, "step": bits, "is_end": 1})
        sought, fetched, compared = (Signal(search, name=name, reset_less=True)
                                     for name in ("sought", "fetched", "compared"))
        in_flight = Signal(3)
        exists, following = Signal(reset_less=True), [Signal(shape, name=f"after_{more}", reset_less=True)
                                                      for more in range(2)]
        # A position that has been read, and the bound that it is compared with.
        address, position = Signal(shape, reset_less=True), Signal(formats.position, reset_less=True)
        limit = Signal(formats.position_bound, reset_less=True)
        less, goes_on = Signal(), Signal()
        m.d.comb += [
            read.addr.eq(address),
            less.eq(exists & (position < limit)),
            goes_on.eq(in_flight[2] & ~compared.step[0])]
        m.d.sync += [in_flight.eq(Cat(goes_on | starts.any(), in_flight[:2])), fetched.eq(sought), compared.eq(fetched),
                     position.eq(read.data), limit.eq(Mux(fetched.is_end, given.end, given.low)),
                     exists.eq((fetched.found | fetched.step) <= given.count)]
        half = fetched.step >> 1
        m.d.sync += [following[0].eq(before + (fetched.found | half)),
                     following[1].eq(before + (fetched.found | fetched.step | half))]
        found = Signal(bits)
        m.d.comb += found.eq(compared.found | Mux(less, compared.step, 0))
        m.d.sync += [sought.found.eq(found), sought.step.eq(compared.step >> 1), sought.is_end.eq(compared.is_end),
                     address.eq(Mux(less, following[1], following[0]))]
        with m.If(starts.any()):
            m.d.sync += [sought.found.eq(0), sought.step.eq(highest), sought.is_end.eq(starts[1]),
                         address.eq(before + highest)]

        # Registered: the outcome of a comparison goes to few bits at once.
        bound = formats.position_bound
        looked = Signal(StructLayout({
            "exists": 1, "less": 1, "is_end": 1, "position": formats.position, "found": bits}), reset_less=True)
        looks, ends = Signal(), Signal()
        m.d.sync += [looks.eq(in_flight[2]), ends.eq(in_flight[2] & compared.step[0]), looked.exists.eq(exists),
                     looked.less.eq(less), looked.is_end.eq(compared.is_end), looked.position.eq(position),
                     looked.found.eq(found)]
        # The last position that was less is the one before the first that was not, and both have been looked at.
        for is_end, target in enumerate((self.o.payload.low, self.o.payload.end)):
            with m.If(starts[is_end]):
                m.d.sync += [target.least.eq(-(1 << bound.width - 1)), target.most.eq((1 << bound.width - 1) - 1)]
            with m.Elif(looks & looked.exists & (looked.is_end == is_end)):
                with m.If(looked.less):
                    m.d.sync += target.least.eq(looked.position + 1)
                with m.Else():
                    m.d.sync += target.most.eq(looked.position)
            with m.If(ends & (looked.is_end == is_end)):
                m.d.sync += target.count.eq(looked.found)
        with m.If(ends & looked.is_end):
            m.d.sync += [self.o.valid.eq(1), busy.eq(0)]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        return m
