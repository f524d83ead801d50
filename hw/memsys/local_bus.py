"""Local bus: the requests of all clusters to the system bus interface, and its replies to them."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.memsys.path_formats import PathFormats

__all__ = ["LocalBus"]


class LocalBus(wiring.Component):
    """Two buses, so that requests never stand in the way of replies: a request or a beat per cycle each. Who has waited
    longest goes first.

    Beats of replies to requests for cells and for patches come one among the other; those of one kind stay together.

    Parameters
    ----------
    config
        The configuration.
    clusters
        How many, 1 to ``noc.nodes``.

    Members
    -------
    i_request
        An array of `PathFormats.request`, one for each cluster.
    o_reply
        An array of `PathFormats.bus_reply`. Always ready: who asks has room.
    o_request
        `PathFormats.bus_request`.
    i_reply
        An array of two, of replies to requests for cells and for patches.

    Timing
    ------
    Latency: ``1`` cycle each way, if nobody else goes first. One request and one beat per cycle; requests stall with
    ``o_request``.

    Errors
    ------
    ValueError
        Clusters out of range.

    Source: Shen 1993, section 5.3.8.
    """

    latency = 1

    def __init__(self, *, config: Config, clusters: int):
        if not isinstance(clusters, int) or not 1 <= clusters <= config.noc.nodes:
            raise ValueError(f"Clusters must be from 1 to {config.noc.nodes}, not {clusters!r}")
        self._clusters, self._formats = clusters, PathFormats(config)
        formats = self._formats
        super().__init__({
            "i_request": In(stream.Signature(formats.request)).array(clusters),
            "o_reply": Out(stream.Signature(formats.bus_reply, always_ready=True)).array(clusters),
            "o_request": Out(stream.Signature(formats.bus_request)),
            "i_reply": In(stream.Signature(formats.bus_reply)).array(2)})

    def elaborate(self, platform):
        m = Module()
        policy = ArbiterPolicy.LONGEST_WAITING
        m.submodules.requests = requests = Arbiter(self._formats.request, count=self._clusters, policy=policy)
        m.submodules.replies = replies = Arbiter(self._formats.bus_reply, count=2, policy=policy)
        for given, taken in (*zip(self.i_request, requests.i, strict=True), *zip(self.i_reply, replies.i, strict=True)):
            wiring.connect(m, wiring.flipped(given), taken)
        asked, beat = requests.o, replies.o
        m.d.comb += [
            self.o_request.valid.eq(asked.valid), asked.ready.eq(self.o_request.ready),
            self.o_request.payload.source.eq(asked.payload.source), self.o_request.payload.item.eq(asked.payload.item),
            beat.ready.eq(1)]
        for number, reply in enumerate(self.o_reply):
            item = beat.payload.item
            m.d.comb += [reply.payload.eq(item), reply.valid.eq(beat.valid & (item.cluster == number))]
        return m
