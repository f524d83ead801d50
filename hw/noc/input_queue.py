"""Input queue: the flits of one virtual channel of an input port."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.checks import count_entries, count_steps
from hw.lib.validate import check_integer
from hw.noc.flit import flit

__all__ = ["InputQueue"]


class InputQueue(wiring.Component):
    """Keeps flits in order, with the route of each packet.

    A packet's first flit carries the destination, for which a table gives one of the queue's routes: an output port and
    a channel there. The other flits follow the first.

    Parameters
    ----------
    bits
        Of the data of a flit.
    depth
        Capacity in flits, at least 1.
    single_cycle
        A flit's data appear in the cycle in which it leaves, or else in the next one.
    routes
        The number of the route to each destination whose packets can arrive here. A corrupted destination is given one
        of these routes too, so that the packet leaves the network.
    node_bits
        Bits of a node's number, if the routes depend on it: then they are of destinations whose bits are below those of
        the number; 0 otherwise.

    Members
    -------
    i : In, stream of `flit`, always ready
        Flits; the sender counts the free entries.
    front : Out, struct of ``valid``, ``first``, ``last``, ``route``
        The flit at the head: whether it is its packet's first or last one, and the number of its route.
    node : In(node_bits)
        The router's node, stable. Only if the routes depend on it.
    pop : In(1)
        The flit at the head leaves in this cycle.
    data : Out(bits)
        Data of the flit that leaves, or that left in the cycle before.

    Timing
    ------
    Latency: ``1`` cycle to ``front``. One flit per cycle in and out.

    Raises
    ------
    TypeError
        The depth is no integer.
    ValueError
        The depth is out of range, or there are no routes.
    """

    def __init__(self, *, bits: int, depth: int, routes: dict[int, int], node_bits: int = 0,
                 single_cycle: bool = False):
        check_integer("Depth", depth, minimum=1)
        if not routes:
            raise ValueError("Routes must be of at least one destination, not {}")
        self._bits, self._depth, self._routes, self._single_cycle = bits, depth, routes, single_cycle
        self._route, self._node_bits = range(max(routes.values()) + 1), node_bits
        self._control = StructLayout({"route": self._route, "first": 1, "last": 1})
        super().__init__({
            "i": In(stream.Signature(flit(bits), always_ready=True)),
            "front": Out(StructLayout({"valid": 1, "first": 1, "last": 1, "route": self._route})),
            "pop": In(1), "data": Out(bits), **({"node": In(node_bits)} if node_bits else {})})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        attributes = {"ram_style": "distributed"}
        m.submodules.data = data = Memory(shape=self._bits, depth=self._depth, init=[], attrs=attributes)
        m.submodules.control = control = Memory(shape=self._control, depth=self._depth, init=[], attrs=attributes)
        head, tail = (Signal(range(self._depth)) for _ in range(2))
        shown = head
        level = Signal(range(self._depth + 1))
        route, kept = Signal(self._route), Signal(self._route, reset_less=True)

        with m.If(self.i.payload.first):
            m.d.comb += route.eq(self._look_up(m, self.i.payload.data))
        with m.Else():
            m.d.comb += route.eq(kept)
        with m.If(self.i.valid):
            m.d.sync += [kept.eq(route), tail.eq(self._after(tail))]
        with m.If(self.pop):
            m.d.sync += head.eq(self._after(head))
        count_entries(level)
        count_steps(m, level, up=self.i.valid, down=self.pop, most=self._depth)
        if not self._single_cycle:
            shown = Signal.like(head, name="left")
            m.d.sync += shown.eq(head)

        write, write_control = data.write_port(), control.write_port()
        read, read_control = data.read_port(domain="comb"), control.read_port(domain="comb")
        m.d.comb += [
            write.en.eq(self.i.valid), write.addr.eq(tail), write.data.eq(self.i.payload.data),
            write_control.en.eq(self.i.valid), write_control.addr.eq(tail), write_control.data.route.eq(route),
            write_control.data.first.eq(self.i.payload.first), write_control.data.last.eq(self.i.payload.last),
            read.addr.eq(shown), self.data.eq(read.data), read_control.addr.eq(head), self.front.valid.eq(level != 0),
            self.front.route.eq(read_control.data.route), self.front.first.eq(read_control.data.first),
            self.front.last.eq(read_control.data.last)]
        return m

    def _after(self, entry):
        return Mux(entry == self._depth - 1, 0, entry + 1)

    def _look_up(self, m, data):
        """The route to a destination; destinations that cannot occur share the commonest one."""
        found = Signal(self._route)
        commonest = max(set(self._routes.values()), key=list(self._routes.values()).count)
        m.d.comb += found.eq(commonest)
        key = Cat(data[:self._node_bits], self.node) if self._node_bits else data[:max(self._routes).bit_length()]
        with m.Switch(key):
            for route in sorted(set(self._routes.values()) - {commonest}):
                with m.Case(*(destination for destination, its in self._routes.items() if its == route)):
                    m.d.comb += found.eq(route)
        return found
