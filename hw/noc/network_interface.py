"""Network interface: patch requests and replies of a cluster, and the packets that carry them."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.credit_gate import CreditGate
from hw.lib.queue import Queue
from hw.lib.validate import check_integer
from hw.noc.flit import link
from hw.noc.link_receiver import LinkReceiver
from hw.noc.link_sender import LinkSender
from hw.noc.network_fault import NetworkFault
from hw.noc.noc_tables import CHECK_BITS, Routing
from hw.noc.packer import Packer
from hw.noc.packet_headers import packet_headers
from hw.noc.unpacker import Unpacker

__all__ = ["NetworkInterface", "interface_members"]


def interface_members(config: Config, nodes: int) -> dict:
    """The members at the cluster's side."""
    formats = Formats(config)
    address = (nodes - 1).bit_length()
    request = stream.Signature(StructLayout({"node": address, "patch": formats.patch}))
    reply = stream.Signature(StructLayout({"node": address, "vertex": formats.patch_vertex}))
    return {"i_request": In(request), "o_request": Out(request), "i_reply": In(reply),
            "o_reply": Out(stream.Signature(formats.patch_vertex)), "fault": Out(NetworkFault)}


class NetworkInterface(wiring.Component):
    """Requests patches from other clusters and replies to their requests.

    A request is a packet of one flit and a reply one of five, if a vertex fits into a flit. A request reserves
    buffer entries for its whole reply before it is sent, so replies never block in the network and nothing can
    deadlock. Replies from a cluster arrive in the order of the requests to it.

    Parameters
    ----------
    config
        The configuration.
    routing
        Of both networks, or of both kinds of messages in one.
    node
        The cluster's node.

    Members
    -------
    i_request : In, stream of ``node``, ``patch``
        Requests of this cluster, and to which node.
    o_reply : Out, stream of `Formats.patch_vertex`
        The replies: four vertices of a patch follow each other.
    o_request : Out, stream of ``node``, ``patch``
        Requests to this cluster, and from which node.
    i_reply : In, stream of ``node``, ``vertex``
        Replies: four `Formats.patch_vertex` follow each other, with the same node and patch. Replies to one node are
        in the order of its requests.
    o, i : Out, In, a stream of `link` per network, always ready
        Links to the routers and from them: requests first, then replies; one link for both if the networks are virtual.
    i_credit, o_credit : In, Out, a bit per channel of each network
        Credit return of these links.
    fault : Out, `NetworkFault`
        The first fault since reset. A faulty flit is passed on nevertheless.

    Timing
    ------
    Latency: ``1`` cycle from ``i_request`` to the link, ``1`` from the link to ``o_request``, ``2`` from the link of a
    vertex' last flit to ``o_reply``. One flit per cycle and link.

    Raises
    ------
    TypeError
        The node is no integer.
    ValueError
        The network has no such node.

    Golden counterpart: `golden.engine.noc.packing`. Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, *, config: Config, routing: Routing, node: int):
        check_integer("Node", node, minimum=0, maximum=routing.topology.nodes - 1)
        self._config, self._routing, self._node = config, routing, node
        self._formats, noc = Formats(config), config.noc
        address = (routing.topology.nodes - 1).bit_length()
        self._request = StructLayout({"node": address, "patch": self._formats.patch})
        self._request_header, self._reply_header = packet_headers(config, routing.topology.nodes).values()
        self._bits = noc.flit_bits + CHECK_BITS[noc.check]
        self._links, self._messages = (1, 2) if noc.networks == "virtual" else (2, 1)
        channels = self._messages * routing.virtual_channels
        links = stream.Signature(link(self._bits, channels), always_ready=True)
        super().__init__({
            **interface_members(config, routing.topology.nodes),
            "i": In(links).array(self._links), "o": Out(links).array(self._links),
            "i_credit": In(channels).array(self._links), "o_credit": Out(channels).array(self._links)})

    def elaborate(self, platform):
        m = Module()
        outgoing, incoming = self._add_links(m)
        noc = self._config.noc
        check = {"bits": noc.flit_bits, "method": noc.check}
        vertex = self._formats.scene_vector

        # Outgoing requests, each with buffer entries reserved for the reply.
        m.submodules.gate = gate = CreditGate(self._request, credits=noc.requests)
        m.submodules.request_packer = packer = Packer(self._request_header, 0, bodies=0, **check)
        wiring.connect(m, wiring.flipped(self.i_request), gate.i)
        wiring.connect(m, packer.o, outgoing[0])
        header = packer.i.payload.header
        m.d.comb += [packer.i.valid.eq(gate.o.valid), gate.o.ready.eq(packer.i.ready),
                     header.destination.eq(gate.o.payload.node), header.source.eq(self._node),
                     header.patch.eq(gate.o.payload.patch)]

        # Incoming replies.
        m.submodules.reply_unpacker = replies = Unpacker(
            self._reply_header, vertex, bodies=VERTICES, node=self._node, **check)
        m.submodules.replies = buffer = Queue(self._formats.patch_vertex, depth=VERTICES * noc.requests)
        wiring.connect(m, incoming[1], replies.i)
        wiring.connect(m, buffer.o, wiring.flipped(self.o_reply))
        left = Signal(range(VERTICES))
        transfer = self.o_reply.valid & self.o_reply.ready
        with m.If(transfer):
            m.d.sync += left.eq(left + 1)
        m.d.comb += [
            buffer.i.valid.eq(replies.o.valid), replies.o.ready.eq(buffer.i.ready),
            buffer.i.payload.patch.eq(replies.o.payload.header.patch),
            buffer.i.payload.surface.eq(replies.o.payload.header.surface),
            buffer.i.payload.vertex.eq(replies.o.payload.body),
            gate.i_return.valid.eq(transfer & (left == VERTICES - 1))]

        # Incoming requests, and outgoing replies.
        m.submodules.request_unpacker = requests = Unpacker(self._request_header, 0, bodies=0, node=self._node, **check)
        m.submodules.reply_packer = packer = Packer(self._reply_header, vertex, bodies=VERTICES, **check)
        wiring.connect(m, incoming[0], requests.i)
        wiring.connect(m, packer.o, outgoing[1])
        header, request, reply = packer.i.payload.header, requests.o.payload.header, self.i_reply.payload
        m.d.comb += [
            self.o_request.valid.eq(requests.o.valid), requests.o.ready.eq(self.o_request.ready),
            self.o_request.payload.node.eq(request.source), self.o_request.payload.patch.eq(request.patch),
            packer.i.valid.eq(self.i_reply.valid), self.i_reply.ready.eq(packer.i.ready),
            header.destination.eq(reply.node), header.source.eq(self._node), header.patch.eq(reply.vertex.patch),
            header.surface.eq(reply.vertex.surface), packer.i.payload.body.eq(reply.vertex.vertex)]

        with m.If(self.fault == NetworkFault.NONE):
            with m.If(requests.fault != NetworkFault.NONE):
                m.d.sync += self.fault.eq(requests.fault)
            with m.Else():
                m.d.sync += self.fault.eq(replies.fault)
        return m

    def _add_links(self, m):
        """Streams of flits out and in, of requests and of replies."""
        outgoing, incoming = [], []
        routing, depth = self._routing, self._config.noc.buffer_flits
        shared = {"bits": self._bits, "channels": routing.virtual_channels, "messages": self._messages, "depth": depth}
        for number in range(self._links):
            m.submodules[f"sender_{number}"] = sender = LinkSender(entry=routing.entry[self._node].tolist(), **shared)
            m.submodules[f"receiver_{number}"] = receiver = LinkReceiver(**shared)
            wiring.connect(m, sender.o, wiring.flipped(self.o[number]))
            wiring.connect(m, wiring.flipped(self.i[number]), receiver.i)
            m.d.comb += [sender.i_credit.eq(self.i_credit[number]), self.o_credit[number].eq(receiver.o_credit)]
            outgoing += list(sender.i)
            incoming += list(receiver.o)
        return outgoing, incoming
