"""Input queue: the flits of one virtual channel of an input port."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.noc.flit import flit

__all__ = ["InputQueue"]


class InputQueue(wiring.Component):
    """Keeps flits in order, and knows of the first one where it is to go.

    A packet's first flit brings the destination, for which a table names one of the ways out; the others follow it.

    Parameters
    ----------
    bits
        Of the data of a flit.
    depth
        Flits that it holds, at least 1.
    at_once
        The data of a flit come in the cycle in which it is taken, or else in the next one.
    ways
        From a destination to the number of its way; from no other destination does a packet come here, and if its
        destination was corrupted it goes one of these ways too: so it leaves the network sooner or later.

    Members
    -------
    i
        Flits; always ready, the sender counts places.
    front
        ``valid``, and of the flit that is the first in the queue: ``way``, ``first``, ``last`` of its packet.
    takes
        That flit leaves in this cycle.
    data
        Of the flit that leaves, or that left in the cycle before.

    Timing
    ------
    Latency: ``1`` cycle to ``front``. One flit per cycle in and out.

    Raises
    ------
    ValueError
        Depth out of range, or no ways.
    """

    def __init__(self, *, bits: int, depth: int, ways: dict[int, int], at_once: bool = False):
        if not isinstance(depth, int) or depth < 1:
            raise ValueError(f"Depth must be at least 1, not {depth!r}")
        if not ways:
            raise ValueError("Ways must be of at least one destination, not {}")
        self._bits, self._depth, self._ways, self._at_once = bits, depth, ways, at_once
        self._way = range(max(ways.values()) + 1)
        self._control = StructLayout({"way": self._way, "first": 1, "last": 1})
        super().__init__({
            "i": In(stream.Signature(flit(bits), always_ready=True)),
            "front": Out(StructLayout({"valid": 1, "first": 1, "last": 1, "way": self._way})),
            "takes": In(1), "data": Out(bits)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        attributes = {"ram_style": "distributed"}
        m.submodules.data = data = Memory(shape=self._bits, depth=self._depth, init=[], attrs=attributes)
        m.submodules.control = control = Memory(shape=self._control, depth=self._depth, init=[], attrs=attributes)
        head, tail = (Signal(range(self._depth)) for _ in range(2))
        shown = head
        level = Signal(range(self._depth + 1))
        way, kept = Signal(self._way), Signal(self._way, reset_less=True)

        with m.If(self.i.payload.first):
            m.d.comb += way.eq(self._look_up(m, self.i.payload.data))
        with m.Else():
            m.d.comb += way.eq(kept)
        with m.If(self.i.valid):
            m.d.sync += [kept.eq(way), tail.eq(self._after(tail))]
        with m.If(self.takes):
            m.d.sync += head.eq(self._after(head))
        m.d.sync += level.eq(level + self.i.valid - self.takes)
        if not self._at_once:
            shown = Signal.like(head, name="left")
            m.d.sync += shown.eq(head)

        write, write_control = data.write_port(), control.write_port()
        read, read_control = data.read_port(domain="comb"), control.read_port(domain="comb")
        m.d.comb += [
            write.en.eq(self.i.valid), write.addr.eq(tail), write.data.eq(self.i.payload.data),
            write_control.en.eq(self.i.valid), write_control.addr.eq(tail), write_control.data.way.eq(way),
            write_control.data.first.eq(self.i.payload.first), write_control.data.last.eq(self.i.payload.last),
            read.addr.eq(shown), self.data.eq(read.data), read_control.addr.eq(head), self.front.valid.eq(level != 0),
            self.front.way.eq(read_control.data.way), self.front.first.eq(read_control.data.first),
            self.front.last.eq(read_control.data.last)]
        return m

    def _after(self, place):
        return Mux(place == self._depth - 1, 0, place + 1)

    def _look_up(self, m, data):
        """The way of a destination; those that do not come here share the commonest one."""
        found = Signal(self._way)
        commonest = max(set(self._ways.values()), key=list(self._ways.values()).count)
        m.d.comb += found.eq(commonest)
        with m.Switch(data[:max(self._ways).bit_length()]):
            for way in sorted(set(self._ways.values()) - {commonest}):
                with m.Case(*(destination for destination, its in self._ways.items() if its == way)):
                    m.d.comb += found.eq(way)
        return found
