"""Unpacker: packets of flits to items."""

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.noc.flit import flit
from hw.noc.flit_check import check_of
from hw.noc.network_fault import NetworkFault
from hw.noc.packer import parts_of

__all__ = ["Unpacker"]


class Unpacker(wiring.Component):
    """The inverse of `hw.noc.packer.Packer`. Faults are reported and do not stop it: a flit between packets that is no
    first one is discarded, and a first one within a packet begins a new packet.

    Parameters
    ----------
    header, body, bodies, bits, method
        As the packer's; a header begins with ``destination``.
    node
        The node of this unpacker.

    Members
    -------
    i : In, stream of `flit`
        Flits, with check bits.
    o : Out, stream of ``header``, ``body``
        An item per body, or one per packet without bodies.
    fault : Out, `NetworkFault`
        Of the flit that was accepted in the cycle before.

    Timing
    ------
    Latency: ``0`` cycles from an item's last flit. One flit per cycle; stalls with ``o``.
    """

    def __init__(self, header: StructLayout, body, *, bodies: int, bits: int, method: str, node: int):
        self._bodies, self._bits, self._method, self._node = bodies, bits, method, node
        self._item = StructLayout({"header": header, "body": body})
        self._plain = flit(bits)
        super().__init__({
            "i": In(stream.Signature(flit(bits + len(check_of(method, Signal(self._plain)))))),
            "o": Out(stream.Signature(self._item)), "fault": Out(NetworkFault)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        kept = Signal(self._item, reset_less=True)
        whole = Signal(self._item)
        headers = parts_of(Value.cast(kept.header), self._bits)
        bodies = parts_of(Value.cast(kept.body), self._bits) if self._bodies else []
        shown = (parts_of(Value.cast(whole.header), self._bits)
                 + (parts_of(Value.cast(whole.body), self._bits) if self._bodies else []))
        last = len(headers) + len(bodies) * self._bodies - 1
        number, part = Signal(range(last + 1)), Signal(range(len(shown)))
        # A first flit begins a packet wherever it arrives.
        now, index = Signal.like(number), Signal.like(part)
        flit_in = self.i.payload
        plain = Signal(self._plain)
        m.d.comb += [
            plain.eq(Cat(flit_in.data[:self._bits], flit_in.first, flit_in.last)),
            now.eq(Mux(flit_in.first, 0, number)), index.eq(Mux(flit_in.first, 0, part)), whole.eq(kept)]
        with m.Switch(index):
            for which, (old, new) in enumerate(zip(headers + bodies, shown, strict=True)):
                with m.Case(which):
                    m.d.comb += new.eq(plain.data)
                    with m.If(self.i.valid & self.i.ready):
                        m.d.sync += old.eq(plain.data)
        dropped = ~flit_in.first & (number == 0)
        ends = index == len(shown) - 1
        gives = ends & ~dropped
        m.d.comb += [self.o.payload.eq(whole), self.o.valid.eq(self.i.valid & gives),
                     self.i.ready.eq(self.o.ready | ~gives)]

        m.d.sync += self.fault.eq(NetworkFault.NONE)
        with m.If(self.i.valid & self.i.ready):
            with m.If(~dropped):
                m.d.sync += [number.eq(Mux(now == last, 0, now + 1)),
                             part.eq(Mux(now == last, 0, Mux(ends, len(headers), index + 1)))]
            with m.If(flit_in.data[self._bits:] != check_of(self._method, plain)):
                m.d.sync += self.fault.eq(NetworkFault.CHECK)
            with m.Elif((flit_in.first != (number == 0)) | (flit_in.last != (now == last))):
                m.d.sync += self.fault.eq(NetworkFault.ORDER)
            with m.Elif((now == len(headers) - 1) & (whole.header.destination != self._node)):
                m.d.sync += self.fault.eq(NetworkFault.ADDRESS)
        return m
