"""Link sender: flits of a node to its router."""

from amaranth.hdl import Array, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.round_robin import RoundRobin
from hw.noc.flit import flit, link

__all__ = ["LinkSender"]


class LinkSender(wiring.Component):
    """Sends flits of one kind of message or several, those in turn, while the router has places for them.

    Parameters
    ----------
    bits
        Of the data of a flit.
    entry
        From a destination to the channel in which its packets enter, among those of a kind.
    channels
        Of a kind.
    messages
        Kinds.
    depth
        Places of a queue of the router.

    Members
    -------
    i
        A stream of flits per kind.
    o, i_credit
        The link, and places that are free again.

    Timing
    ------
    Latency: ``1`` cycle. One flit per cycle.

    Golden counterpart: the sources of `golden.noc.network.Network`.
    """

    def __init__(self, *, bits: int, entry: list[int], channels: int, messages: int, depth: int):
        self._entry, self._channels, self._messages, self._depth = entry, channels, messages, depth
        super().__init__({
            "i": In(stream.Signature(flit(bits))).array(messages),
            "o": Out(stream.Signature(link(bits, channels * messages), always_ready=True)),
            "i_credit": In(channels * messages)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.turns = turns = RoundRobin(count=self._messages)
        room = Signal(self._channels * self._messages)
        sent = Signal.like(self.o.payload, reset_less=True)
        m.d.comb += [turns.accept.eq(turns.eligible.any()), self.o.payload.eq(sent)]
        m.d.sync += self.o.valid.eq(turns.accept)
        chosen = []
        for kind, source in enumerate(self.i):
            # The packet's channel follows from its destination, which only its first flit knows.
            lane, kept = (Signal(range(self._channels), name=f"{name}_{kind}") for name in ("lane", "kept"))
            destination = source.payload.data[:max(1, (len(self._entry) - 1).bit_length())]
            entries = Array(Const(entry, lane.shape()) for entry in self._entry)
            m.d.comb += lane.eq(Mux(source.payload.first, entries[destination], kept))
            with m.If(turns.grant[kind]):
                m.d.sync += [kept.eq(lane), sent.flit.eq(source.payload), sent.channel.eq(kind * self._channels + lane)]
            m.d.comb += [
                turns.request[kind].eq(source.valid), source.ready.eq(turns.grant[kind]),
                turns.eligible[kind].eq(source.valid & (room >> kind * self._channels).bit_select(lane, 1))]
            chosen += [turns.grant[kind] & (lane == place) for place in range(self._channels)]
        for channel, goes in enumerate(chosen):
            credits = Signal(range(self._depth + 1), init=self._depth, name=f"credits_{channel}")
            m.d.comb += room[channel].eq(credits != 0)
            m.d.sync += credits.eq(credits + self.i_credit[channel] - goes)
        return m
