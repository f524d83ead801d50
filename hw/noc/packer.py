"""Packer: items to packets of flits."""

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.noc.flit import flit
from hw.noc.flit_check import check_of

__all__ = ["Packer", "parts_of"]


def parts_of(value: Value, bits: int) -> list[Value]:
    """A value in pieces of at most so many bits, lowest first."""
    return [value[first:first + bits] for first in range(0, len(value), bits)]


class Packer(wiring.Component):
    """A packet is a header and a number of bodies, each of which begins with a new flit, lowest bits first.

    Parameters
    ----------
    header, body
        Shapes. Items of a packet have the same header, and a body each; a packet of no bodies is one item.
    bodies
        Of a packet.
    bits
        Of the data of a flit without its check bits, which are above.
    method
        ``none``, ``parity`` or ``crc``: over the data with ``first`` and ``last`` above.

    Members
    -------
    i : In, stream of ``header``, ``body``
        Items of packets.
    o : Out, stream of `flit`
        Flits, with check bits.

    Timing
    ------
    Latency: ``0`` cycles. One flit per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.noc.packing.pack_flits`.
    """

    def __init__(self, header, body, *, bodies: int, bits: int, method: str):
        self._bodies, self._bits, self._method = bodies, bits, method
        item = StructLayout({"header": header, "body": body})
        checked = flit(bits)
        super().__init__({
            "i": In(stream.Signature(item)),
            "o": Out(stream.Signature(flit(bits + len(check_of(method, Signal(checked))))))})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        headers = parts_of(Value.cast(self.i.payload.header), self._bits)
        bodies = parts_of(Value.cast(self.i.payload.body), self._bits) if self._bodies else []
        last = len(headers) + len(bodies) * self._bodies - 1
        # Which flit of the packet, and which part of an item it is.
        number, part = Signal(range(last + 1)), Signal(range(len(headers) + len(bodies)))
        plain = Signal(flit(self._bits))
        with m.Switch(part):
            for index, value in enumerate(headers + bodies):
                with m.Case(index):
                    m.d.comb += plain.data.eq(value)
        ends = part == len(headers) + len(bodies) - 1
        m.d.comb += [
            plain.first.eq(number == 0), plain.last.eq(number == last), self.o.valid.eq(self.i.valid),
            self.o.payload.first.eq(plain.first), self.o.payload.last.eq(plain.last),
            self.o.payload.data.eq(Cat(plain.data, check_of(self._method, plain))),
            self.i.ready.eq(self.o.ready & ends)]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += [number.eq(Mux(plain.last, 0, number + 1)),
                         part.eq(Mux(plain.last, 0, Mux(ends, len(headers), part + 1)))]
        return m
