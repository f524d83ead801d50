"""Local bus: requests of all clusters to the system bus interface, and its replies."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.skid_buffer import SkidBuffer
from hw.lib.validate import check_integer
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["LocalBus"]


class LocalBus(wiring.Component):
    """Two buses, for a request and for a beat of a reply per cycle, so requests never block replies.

    Both grant the item that has been pending longest. Beats of replies for cells and for patches may alternate; those
    of one kind stay together.

    Parameters
    ----------
    config
        The configuration.
    clusters
        Number of clusters, 1 to ``noc.clusters``.

    Members
    -------
    i_request : In, ``clusters`` streams of `PathFormats.request`
        One for each cluster.
    o_reply : Out, ``clusters`` streams of `PathFormats.bus_reply`
        Always ready: a requester has reserved entries for the whole reply.
    o_request : Out, stream of `PathFormats.bus_request`
        To `SystemBusInterface`.
    i_reply : In, two streams of `PathFormats.bus_reply`
        From there: replies for cells and for patches.

    Timing
    ------
    Latency: ``1`` cycle each way, if no other item is granted. One request and one beat per cycle; requests stall with
    ``o_request``, a cycle later.

    Raises
    ------
    TypeError
        The number of clusters is no integer.
    ValueError
        The number of clusters is out of range.

    Source: Shen 1993, section 5.3.8.
    """

    latency = 1

    def __init__(self, *, config: Config, clusters: int):
        check_integer("Clusters", clusters, minimum=1, maximum=config.noc.clusters)
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
        # Requesters see a register of whether requests are taken, not the memory's side.
        m.submodules.offered = offered = SkidBuffer(requests.o.payload.shape(), bypass=True)
        wiring.connect(m, requests.o, offered.i)
        request, beat = offered.o, replies.o
        m.d.comb += [
            self.o_request.valid.eq(request.valid), request.ready.eq(self.o_request.ready),
            self.o_request.payload.source.eq(request.payload.source),
            self.o_request.payload.item.eq(request.payload.item), beat.ready.eq(1)]
        for number, reply in enumerate(self.o_reply):
            item = beat.payload.item
            m.d.comb += [reply.payload.eq(item), reply.valid.eq(beat.valid & (item.cluster == number))]
        return m
