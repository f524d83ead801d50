"""Read share: several readers at one port."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.validate import check_integer
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["ReadShare"]


class ReadShare(wiring.Component):
    """Shares one port among several readers. The number of a reader is the tag of its requests; the request that has
    been pending longest is granted.

    Parameters
    ----------
    config
        The configuration.
    count
        Number of readers, at least 1.

    Members
    -------
    i_request : In, ``count`` streams of `MemoryFormats.request`
        Of the readers, without a tag.
    o_reply : Out, ``count`` streams of `MemoryFormats.reply`
        Their replies. A reader that stalls its replies stalls those of the others.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``.

    Timing
    ------
    Latency: ``1`` cycle of a request, if no other is granted, ``0`` of a reply. One request and one beat per cycle;
    stalls with ``o_request`` and ``o_reply``.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    latency = 1

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
        self._count, self._formats = count, MemoryFormats(config)
        formats, tag = self._formats, range(count)
        super().__init__({
            "i_request": In(stream.Signature(formats.request(0))).array(count),
            "o_reply": Out(stream.Signature(formats.reply(0))).array(count),
            "o_request": Out(stream.Signature(formats.request(tag))),
            "i_reply": In(stream.Signature(formats.reply(tag)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.requests = requests = Arbiter(self._formats.request(0), count=self._count,
                                             policy=ArbiterPolicy.LONGEST_WAITING)
        for given, taken in zip(self.i_request, requests.i, strict=True):
            wiring.connect(m, wiring.flipped(given), taken)
        granted, out = requests.o.payload, self.o_request.payload
        m.d.comb += [self.o_request.valid.eq(requests.o.valid), requests.o.ready.eq(self.o_request.ready),
                     out.address.eq(granted.item.address), out.length.eq(granted.item.length),
                     out.tag.eq(granted.source)]
        reply_payload = self.i_reply.payload
        for number, reply in enumerate(self.o_reply):
            m.d.comb += [reply.payload[name].eq(reply_payload[name]) for name in ("data", "last", "error")]
            with m.If(reply_payload.tag == number):
                m.d.comb += [reply.valid.eq(self.i_reply.valid), self.i_reply.ready.eq(reply.ready)]
        return m
