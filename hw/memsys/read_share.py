"""Read share: several readers at one port."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["ReadShare"]


class ReadShare(wiring.Component):
    """Requests carry the number of their reader as a tag, by which replies come back. Who has waited longest goes
    first.

    Parameters
    ----------
    config
        The configuration.
    count
        Readers, at least 1.

    Members
    -------
    i_request, o_reply
        An array each of `MemoryFormats.request` and of `MemoryFormats.reply` without a tag. A reader that does not take
        its replies holds up the others.
    o_request, i_reply
        `MainMemoryPort`'s ``i_read`` and ``o_read``, with a reader's number as the tag.

    Timing
    ------
    Latency: ``1`` cycle of a request, if nobody else goes first, ``0`` of a reply. One request and one beat per cycle;
    stalls with ``o_request`` and ``o_reply``.

    Errors
    ------
    ValueError
        Count out of range.
    """

    latency = 1

    def __init__(self, *, config: Config, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        self._count, self._formats = count, MemoryFormats(config)
        formats, tag = self._formats, range(count)
        super().__init__({
            "i_request": In(stream.Signature(formats.request(0))).array(count),
            "o_reply": Out(stream.Signature(formats.reply(0))).array(count),
            "o_request": Out(stream.Signature(formats.request(tag))),
            "i_reply": In(stream.Signature(formats.reply(tag)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.turns = turns = Arbiter(self._formats.request(0), count=self._count,
                                             policy=ArbiterPolicy.LONGEST_WAITING)
        for given, taken in zip(self.i_request, turns.i, strict=True):
            wiring.connect(m, wiring.flipped(given), taken)
        asked, out = turns.o.payload, self.o_request.payload
        m.d.comb += [self.o_request.valid.eq(turns.o.valid), turns.o.ready.eq(self.o_request.ready),
                     out.address.eq(asked.item.address), out.length.eq(asked.item.length), out.tag.eq(asked.source)]
        came = self.i_reply.payload
        for number, reply in enumerate(self.o_reply):
            m.d.comb += [reply.payload[name].eq(came[name]) for name in ("data", "last", "error")]
            with m.If(came.tag == number):
                m.d.comb += [reply.valid.eq(self.i_reply.valid), self.i_reply.ready.eq(reply.ready)]
        return m
