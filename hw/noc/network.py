"""Network: routers and the links between them."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.arbiter import ArbiterPolicy
from hw.lib.checks import count_entries, count_steps, has_checks
from hw.noc.flit import link
from hw.noc.noc_tables import LOCAL, Routing, check_deadlock_free
from hw.noc.router import Router

__all__ = ["Network"]


class Network(wiring.Component):
    """A router for each node of a topology, and its links.

    Parameters
    ----------
    routing
        Topology and routes.
    bits, depth, messages, router_cycles, policy
        Of the routers.

    Members
    -------
    i, o : In, Out, a stream of `link` per node, always ready
        The links to each router and from it; packets of a kind leave one after the other, each whole.
    o_credit, i_credit : Out, In, a bit per channel of each node
        Credit return of these links.
    flits : Out(32)
        Flits sent by all routers since reset, over links and to nodes; wraps.
    stalls : Out(32)
        Cycles since reset in which flits waited for a port and none was eligible, summed over all ports; wraps.

    Timing
    ------
    Latency: ``(router_cycles + 1) * (hops + 1)`` cycles from ``i`` to ``o`` in an empty network: those in a router, and
    1 on the link behind it. One flit per node and cycle.

    Raises
    ------
    InputError
        Channels could deadlock: the cycle is named.
    ValueError
        As `Router`.

    Golden counterpart: `golden.engine.noc.network`. Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, *, routing: Routing, bits: int, depth: int, messages: int = 1,
                 router_cycles: int = 2, policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        check_deadlock_free(routing)
        self._routing = routing
        self._router = {"routing": routing, "bits": bits, "depth": depth, "messages": messages,
                        "router_cycles": router_cycles, "policy": policy}
        channels, nodes = messages * routing.virtual_channels, routing.topology.nodes
        links = stream.Signature(link(bits, channels), always_ready=True)
        super().__init__({
            "i": In(links).array(nodes), "o": Out(links).array(nodes),
            "i_credit": In(channels).array(nodes), "o_credit": Out(channels).array(nodes),
            "flits": Out(32), "stalls": Out(32)})

    def elaborate(self, platform):
        m = Module()
        routers = [Router(node=node, **self._router) for node in range(self._routing.topology.nodes)]
        moves, stalls = [], []
        for node, router in enumerate(routers):
            m.submodules[f"router_{node}"] = router
            wiring.connect(m, wiring.flipped(self.i[node]), router.i[LOCAL])
            wiring.connect(m, router.o[LOCAL], wiring.flipped(self.o[node]))
            m.d.comb += [self.o_credit[node].eq(router.o_credit[LOCAL]),
                         router.i_credit[LOCAL].eq(self.i_credit[node])]
            moves += list(router.moves)
            stalls += list(router.stalls)
        for edge in self._routing.topology.links:
            source, target = routers[edge.source], routers[edge.target]
            wiring.connect(m, source.o[edge.output], target.i[edge.input])
            m.d.comb += source.i_credit[edge.output].eq(target.o_credit[edge.input])
        self._add_check(m)
        for counter, events in ((self.flits, moves), (self.stalls, stalls)):
            m.d.sync += counter.eq(counter + self._add_count(m, events))
        return m

    def _add_check(self, m):
        """Flits are conserved: those that have entered and not left are in queues and on links."""
        if has_checks():
            inside, (enters, leaves) = Signal(16, name="flits_inside"), (
                sum(one.valid for one in links) for links in (self.i, self.o))
            count_entries(inside)
            count_steps(m, inside, up=enters, down=leaves, most=(1 << len(inside)) - 1)

    @staticmethod
    def _add_count(m, events):
        """The number of events, in a tree of adders with a register per level."""
        level = events
        while len(level) > 1:
            sums = []
            for pair in zip(level[::2], level[1::2], strict=False):
                total = Signal(range(2 * (1 << len(pair[0])) - 1), name="total")
                m.d.sync += total.eq(pair[0] + pair[1])
                sums.append(total)
            if len(level) % 2:
                rest = Signal.like(level[-1], name="rest")
                m.d.sync += rest.eq(level[-1])
                sums.append(rest)
            level = sums
        return level[0]
