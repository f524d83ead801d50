"""Output port: which flit leaves, on which virtual channel."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.arbiter import ArbiterPolicy
from hw.noc.flit import link

__all__ = ["OutputPort"]


class OutputPort(wiring.Component):
    """Gives one flit per cycle to the link: of the queues whose first flit is to leave here and may, the next in turn.

    A packet's first flit may go on a channel that no packet holds, the others on that which theirs holds; and only
    while the queue behind the channel has a place, for which there is a credit. The packet's last flit leaves the
    channel to the next packet in the cycle after.

    Parameters
    ----------
    bits
        Of the data of a flit.
    channels
        Of the link.
    sources
        Queues that send here, at least 1.
    depth
        Places of the queues behind the channels.
    at_once
        A flit passes the crossbar in the cycle in which it leaves its queue, or else in the next one.
    policy
        Whose turn it is; a flit waits from the cycle on in which it is its queue's first one.

    Members
    -------
    fronts
        Of each queue: ``valid`` if its first flit is to leave here, on which ``channel``, ``first``, ``last`` of its
        packet.
    takes
        The flit of this queue leaves.
    data
        Of the flit that leaves, or that left in the cycle before.
    i_credit
        A place is free again, a bit per channel.
    o
        The link.
    stalls
        Flits wait for this port and none of them may leave.

    Timing
    ------
    Latency: ``2`` cycles from ``fronts`` to ``o``, ``1`` if at once. One flit per cycle.
    """

    def __init__(self, *, bits: int, channels: int, sources: int, depth: int, at_once: bool = False,
                 policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        self._policy, self._at_once = policy, at_once
        self._bits, self._channels, self._sources, self._depth = bits, channels, sources, depth
        front = StructLayout({"valid": 1, "first": 1, "last": 1, "channel": range(channels)})
        super().__init__({
            "fronts": In(ArrayLayout(front, sources)), "takes": Out(sources), "data": In(ArrayLayout(bits, sources)),
            "i_credit": In(channels), "o": Out(stream.Signature(link(bits, channels), always_ready=True)),
            "stalls": Out(1)})
        self.latency = 1 if at_once else 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.turns = turns = self._policy.rule(count=self._sources)
        free, room = Signal(self._channels, init=-1), Signal(self._channels)
        goes = turns.grant
        for k, front in enumerate(self.fronts):
            can = [(front.channel == channel) & room[channel] & (free[channel] | ~front.first)
                   for channel in range(self._channels)]
            m.d.comb += [turns.request[k].eq(front.valid), turns.eligible[k].eq(front.valid & Cat(can).any())]
        m.d.comb += [turns.accept.eq(turns.eligible.any()), self.takes.eq(goes),
                     self.stalls.eq(turns.request.any() & ~turns.accept)]

        for channel in range(self._channels):
            credits = Signal(range(self._depth + 1), init=self._depth, name=f"credits_{channel}")
            used = Cat(goes[k] & (front.channel == channel) for k, front in enumerate(self.fronts)).any()
            ends = Cat(goes[k] & front.last for k, front in enumerate(self.fronts)).any()
            m.d.comb += room[channel].eq(credits != 0)
            m.d.sync += credits.eq(credits + self.i_credit[channel] - used)
            with m.If(used):
                m.d.sync += free[channel].eq(ends)

        # What crosses now, or in the next cycle.
        domain = m.d.comb if self._at_once else m.d.sync
        crosses, source = Signal(), Signal(range(self._sources), reset_less=True)
        crossing = Signal.like(self.o.payload, reset_less=True)
        domain += [crosses.eq(turns.accept), source.eq(self._of(goes, range(self._sources))),
                   crossing.flit.first.eq(self._of(goes, [front.first for front in self.fronts])),
                   crossing.flit.last.eq(self._of(goes, [front.last for front in self.fronts])),
                   crossing.channel.eq(self._of(goes, [front.channel for front in self.fronts]))]
        sent = Signal.like(self.o.payload, reset_less=True)
        # There is no time to make a number of the one that goes.
        data = self._of(goes, self.data) if self._at_once else self.data[source]
        m.d.comb += self.o.payload.eq(sent)
        m.d.sync += [sent.eq(crossing), sent.flit.data.eq(data), self.o.valid.eq(crosses)]
        return m

    @staticmethod
    def _of(goes, values):
        """The value of the one that goes."""
        chosen = 0
        for k, value in enumerate(values):
            chosen = chosen | Mux(goes[k], value, 0)
        return chosen
