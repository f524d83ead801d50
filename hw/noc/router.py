"""Router: flits of packets from the links that come in to those that go out."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.noc.reach import reach
from golden.noc.routing import Routing
from hw.lib.arbiter import ArbiterPolicy
from hw.noc.flit import link
from hw.noc.input_queue import InputQueue
from hw.noc.output_port import OutputPort

__all__ = ["Router"]


class Router(wiring.Component):
    """A wormhole router with credits and virtual channels, for one node of a network.

    Each virtual channel of each input port has a queue of its own, and all of them may send in the same cycle; each
    output port takes one flit per cycle from them, in turn. A packet takes the same channels as every other one from
    its source to its destination, so packets cannot overtake each other. What no packet can need is not built: queues
    of channels that none takes, and turns from a queue to a port.

    Parameters
    ----------
    routing
        Of the network.
    node
        Which router of it.
    bits
        Of the data of a flit; those of a packet's first flit begin with its destination.
    depth
        Flits in a queue, at least 1.
    messages
        Kinds of messages, which never wait for each other; each has channels of its own.
    router_cycles
        1 or 2: a flit is chosen, and passes the crossbar, in the same cycle or in two.
    policy
        Which of the flits that may leave at a port goes first.

    Members
    -------
    i, o
        Links, by port.
    o_credit, i_credit
        Per link of the other direction: a queue has a place again, a bit per channel.
    moves, stalls
        Per output port: a flit was sent; flits waited and none could be sent. One cycle later.

    Timing
    ------
    Latency: ``router_cycles + 1`` cycles from ``i`` to ``o``: into the queue, arbitration and crossbar, onto the link.
    One flit per port and cycle. A place is given back two cycles after its flit came, at the earliest, and
    ``router_cycles + 3`` cycles lie between two uses of a place: a queue of so many flits is never the reason to wait.

    Raises
    ------
    ValueError
        Depth, messages, cycles or bits out of range, or no such node.

    Golden counterpart: `golden.noc.router`. Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, *, routing: Routing, node: int, bits: int, depth: int, messages: int = 1,
                 router_cycles: int = 2, policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        nodes = routing.topology.nodes
        if not isinstance(node, int) or not 0 <= node < nodes:
            raise ValueError(f"Node must be from 0 to {nodes - 1}, not {node!r}")
        if not isinstance(messages, int) or messages < 1:
            raise ValueError(f"Messages must be at least 1, not {messages!r}")
        if not isinstance(bits, int) or bits < max(1, (nodes - 1).bit_length()):
            raise ValueError(f"Bits must be at least those of a node's number, not {bits!r}")
        if not isinstance(depth, int) or depth < 1:
            raise ValueError(f"Depth must be at least 1, not {depth!r}")
        if router_cycles not in (1, 2):
            raise ValueError(f"Router cycles must be 1 or 2, not {router_cycles!r}")
        self._routing, self._node, self._bits, self._depth = routing, node, bits, depth
        self._messages, self._policy, self._at_once = messages, policy, router_cycles == 1
        self._channels = messages * routing.virtual_channels
        ports = len(routing.topology.ports)
        links = stream.Signature(link(bits, self._channels), always_ready=True)
        super().__init__({
            "i": In(links).array(ports), "o": Out(links).array(ports),
            "i_credit": In(self._channels).array(ports), "o_credit": Out(self._channels).array(ports),
            "moves": Out(ports), "stalls": Out(ports)})
        self.latency = router_cycles + 1

    def elaborate(self, platform):
        m = Module()
        senders = self._add_queues(m)
        for port, name in enumerate(self._routing.topology.ports):
            sources = [(queue, ways) for queue, ways in senders if any(output == port for output, _ in ways)]
            if not sources:
                continue
            m.submodules[f"output_{name}"] = output = OutputPort(
                bits=self._bits, channels=self._channels, sources=len(sources), depth=self._depth,
                at_once=self._at_once, policy=self._policy)
            wiring.connect(m, output.o, wiring.flipped(self.o[port]))
            m.d.comb += output.i_credit.eq(self.i_credit[port])
            m.d.sync += [self.moves[port].eq(output.takes.any()), self.stalls[port].eq(output.stalls)]
            for k, (queue, ways) in enumerate(sources):
                front = output.fronts[k]
                m.d.comb += [front.first.eq(queue.front.first), front.last.eq(queue.front.last),
                             output.data[k].eq(queue.data)]
                # One bit per way: a comparison with a way of no bits would be lost in synthesis.
                for number, (its_port, channel) in enumerate(ways):
                    if its_port == port:
                        with m.If((queue.front.way == number) if len(ways) > 1 else 1):
                            m.d.comb += [front.valid.eq(queue.front.valid), front.channel.eq(channel)]
                with m.If(output.takes[k]):
                    m.d.comb += queue.takes.eq(1)
        return m

    def _add_queues(self, m):
        """The queues that packets come into, each with its ways: output ports and channels."""
        routing, node, per_kind = self._routing, self._node, self._routing.virtual_channels
        comes = reach(routing)[node]
        senders = []
        for port, name in enumerate(routing.topology.ports):
            given_back = Signal(self._channels, name=f"given_back_{name}")
            m.d.comb += self.o_credit[port].eq(given_back)
            for channel in range(self._channels):
                kind, lane = divmod(channel, per_kind)
                goals = comes[port, lane].nonzero()[0].tolist()
                if not goals:
                    continue
                targets = {goal: (int(routing.port[node, goal]), kind * per_kind + int(routing.channel[node, goal]))
                           for goal in goals}
                ways = sorted(set(targets.values()))
                queue = InputQueue(bits=self._bits, depth=self._depth, at_once=self._at_once,
                                   ways={goal: ways.index(target) for goal, target in targets.items()})
                m.submodules[f"queue_{name}_{channel}"] = queue
                m.d.comb += [queue.i.payload.eq(self.i[port].payload.flit),
                             queue.i.valid.eq(self.i[port].valid & (self.i[port].payload.channel == channel))]
                m.d.sync += given_back[channel].eq(queue.takes)
                senders.append((queue, ways))
        return senders
