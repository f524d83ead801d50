"""Router: flits from input links to output links."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.arbiter import ArbiterPolicy
from hw.lib.validate import check_integer
from hw.noc.flit import link
from hw.noc.input_queue import InputQueue
from hw.noc.noc_tables import Routing, reach
from hw.noc.output_port import OutputPort

__all__ = ["Router"]


class Router(wiring.Component):
    """A wormhole router with credits and virtual channels, for one node of a network.

    Each virtual channel of each input port has a queue of its own, and all of them may send in the same cycle; each
    output port grants one flit per cycle. All packets from a source to a destination use the same channels, so they
    cannot overtake each other. Queues and crossbar paths that no route uses are not built.

    Parameters
    ----------
    routing
        Of the network.
    node
        The router's node; None: an input says it, and the router has the queues and paths of all nodes.
    bits
        Of the data of a flit; those of a packet's first flit begin with its destination.
    depth
        Capacity of a queue in flits, at least 1.
    messages
        Kinds of messages, which never block each other: each has channels of its own.
    router_cycles
        1 or 2: arbitration and crossbar take the same cycle or one each.
    policy
        Arbitration policy of the output ports.

    Members
    -------
    i, o : In, Out, a stream of `link` per port, always ready
        The links.
    o_credit, i_credit : Out, In, a bit per channel of each port
        Credit return of these links.
    node : In(range(nodes))
        The router's node, if it is an input. Stable.
    moves : Out(ports)
        A flit was sent at the port in the cycle before.
    stalls : Out(ports)
        Flits waited for the port in the cycle before, and none was eligible.

    Timing
    ------
    Latency: ``router_cycles + 1`` cycles from ``i`` to ``o``: into the queue, arbitration and crossbar, onto the link.
    One flit per port and cycle. A credit returns two cycles after its flit arrived, at the earliest, and an entry is
    used again after ``router_cycles + 3`` cycles: queues of so many flits never limit the throughput.

    Raises
    ------
    TypeError
        Depth, messages, bits or node are no integers.
    ValueError
        Depth, messages, cycles, bits or node are out of range.

    Golden counterpart: `golden.engine.noc.router`. Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, *, routing: Routing, node: int | None, bits: int, depth: int, messages: int = 1,
                 router_cycles: int = 2, policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        nodes = routing.topology.nodes
        if node is not None:
            check_integer("Node", node, minimum=0, maximum=nodes - 1)
        check_integer("Messages", messages, minimum=1)
        check_integer("Bits", bits, minimum=max(1, (nodes - 1).bit_length()))
        check_integer("Depth", depth, minimum=1)
        if router_cycles not in (1, 2):
            raise ValueError(f"Router cycles must be 1 or 2, not {router_cycles!r}")
        self._routing, self._node, self._bits, self._depth = routing, node, bits, depth
        self._policy, self._single_cycle = policy, router_cycles == 1
        self._channels = messages * routing.virtual_channels
        ports = len(routing.topology.ports)
        links = stream.Signature(link(bits, self._channels), always_ready=True)
        super().__init__({
            "i": In(links).array(ports), "o": Out(links).array(ports),
            "i_credit": In(self._channels).array(ports), "o_credit": Out(self._channels).array(ports),
            "moves": Out(ports), "stalls": Out(ports), **({"node": In(range(nodes))} if node is None else {})})
        self.latency = router_cycles + 1

    def elaborate(self, platform):
        m = Module()
        senders = self._add_queues(m)
        for port, name in enumerate(self._routing.topology.ports):
            sources = [(queue, routes) for queue, routes in senders if any(output == port for output, _ in routes)]
            if not sources:
                continue
            m.submodules[f"output_{name}"] = output = OutputPort(
                bits=self._bits, channels=self._channels, sources=len(sources), depth=self._depth,
                single_cycle=self._single_cycle, policy=self._policy)
            wiring.connect(m, output.o, wiring.flipped(self.o[port]))
            m.d.comb += output.i_credit.eq(self.i_credit[port])
            m.d.sync += [self.moves[port].eq(output.grant.any()), self.stalls[port].eq(output.stalls)]
            for k, (queue, routes) in enumerate(sources):
                head = output.heads[k]
                m.d.comb += [head.first.eq(queue.front.first), head.last.eq(queue.front.last),
                             output.data[k].eq(queue.data)]
                # A queue with one route has a route number of no bits, which cannot be compared.
                for number, (its_port, channel) in enumerate(routes):
                    if its_port == port:
                        with m.If((queue.front.route == number) if len(routes) > 1 else 1):
                            m.d.comb += [head.valid.eq(queue.front.valid), head.channel.eq(channel)]
                with m.If(output.grant[k]):
                    m.d.comb += queue.pop.eq(1)
        return m

    def _add_queues(self, m):
        """The queues that packets use, each with its routes: output ports and channels."""
        routing, per_kind = self._routing, self._routing.virtual_channels
        arriving, senders = reach(routing), []
        nodes = range(len(arriving)) if self._node is None else (self._node,)
        node_bits = (len(arriving) - 1).bit_length() if self._node is None else 0
        for port, name in enumerate(routing.topology.ports):
            credit_return = Signal(self._channels, name=f"credit_return_{name}")
            m.d.comb += self.o_credit[port].eq(credit_return)
            for channel in range(self._channels):
                kind, lane = divmod(channel, per_kind)
                targets = {node: {
                    goal: (int(routing.port[node, goal]), kind * per_kind + int(routing.channel[node, goal]))
                    for goal in arriving[node, port, lane].nonzero()[0].tolist()} for node in nodes}
                routes = sorted({target for its in targets.values() for target in its.values()})
                if not routes:
                    continue
                queue = InputQueue(bits=self._bits, depth=self._depth, single_cycle=self._single_cycle,
                                   node_bits=node_bits, routes=self._table(targets, routes, node_bits))
                m.submodules[f"queue_{name}_{channel}"] = queue
                if node_bits:
                    m.d.comb += queue.node.eq(self.node)
                m.d.comb += [queue.i.payload.eq(self.i[port].payload.flit),
                             queue.i.valid.eq(self.i[port].valid & (self.i[port].payload.channel == channel))]
                m.d.sync += credit_return[channel].eq(queue.pop)
                senders.append((queue, routes))
        return senders

    @staticmethod
    def _table(targets, routes, node_bits):
        """The numbers of a queue's routes by destination; below the bits of the node, if there are any: then of all
        destinations, as each node has a commonest route of its own.
        """
        table = {}
        for node, its in targets.items():
            numbers = {goal: routes.index(target) for goal, target in its.items()}
            if node_bits and numbers:
                found = list(numbers.values())
                numbers = dict.fromkeys(range(1 << node_bits), max(set(found), key=found.count)) | numbers
            table |= {goal | (node << node_bits if node_bits else 0): number for goal, number in numbers.items()}
        return table
