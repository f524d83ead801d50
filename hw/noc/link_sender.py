"""Link sender: flits from a node to its router."""

from amaranth.hdl import Array, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.checks import count_entries, count_steps
from hw.lib.round_robin import RoundRobin
from hw.noc.flit import flit, link

__all__ = ["LinkSender"]


class LinkSender(wiring.Component):
    """Sends the flits of all kinds of messages over one link, in round-robin order, as far as credits allow.

    Parameters
    ----------
    bits
        Of the data of a flit.
    entry
        By destination the channel in which its packets enter, among those of a kind.
    channels
        Number of virtual channels of a kind.
    messages
        Number of kinds.
    depth
        Capacity of a queue of the router.

    Members
    -------
    i : In, ``messages`` streams of `flit`
        Flits of each kind.
    o : Out, stream of `link`, always ready
        The link.
    i_credit : In(channels * messages)
        Credit return of each channel.

    Timing
    ------
    Latency: ``1`` cycle. One flit per cycle.

    Golden counterpart: the sources of `golden.engine.noc.network.Network`.
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
        m.submodules.arbiter = arbiter = RoundRobin(count=self._messages)
        has_credit = Signal(self._channels * self._messages)
        sent = Signal.like(self.o.payload, reset_less=True)
        m.d.comb += [arbiter.accept.eq(arbiter.eligible.any()), self.o.payload.eq(sent)]
        m.d.sync += self.o.valid.eq(arbiter.accept)
        chosen = []
        for kind, source in enumerate(self.i):
            # The packet's channel follows from its destination, which only its first flit carries.
            lane, kept = (Signal(range(self._channels), name=f"{name}_{kind}") for name in ("lane", "kept"))
            destination = source.payload.data[:max(1, (len(self._entry) - 1).bit_length())]
            entries = Array(Const(entry, lane.shape()) for entry in self._entry)
            m.d.comb += lane.eq(Mux(source.payload.first, entries[destination], kept))
            with m.If(arbiter.grant[kind]):
                m.d.sync += [kept.eq(lane), sent.flit.eq(source.payload), sent.channel.eq(kind * self._channels + lane)]
            m.d.comb += [
                arbiter.request[kind].eq(source.valid), source.ready.eq(arbiter.grant[kind]),
                arbiter.eligible[kind].eq(source.valid & (has_credit >> kind * self._channels).bit_select(lane, 1))]
            chosen += [arbiter.grant[kind] & (lane == number) for number in range(self._channels)]
        for channel, is_sent in enumerate(chosen):
            credits = Signal(range(self._depth + 1), init=self._depth, name=f"credits_{channel}")
            m.d.comb += has_credit[channel].eq(credits != 0)
            count_entries(self._depth - credits)
            count_steps(m, credits, up=self.i_credit[channel], down=is_sent, most=self._depth)
        return m
