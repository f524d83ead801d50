"""Output port: switch and channel allocation for one link."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.arbiter import ArbiterPolicy
from hw.lib.checks import claim, count_entries, count_steps
from hw.noc.flit import link

__all__ = ["OutputPort"]


class OutputPort(wiring.Component):
    """Grants one flit per cycle: of the queues whose head is to leave here and is eligible, the next in arbitration.

    A packet's first flit is eligible on a channel that no packet holds, the others on their packet's channel; both only
    with a credit for the queue behind the channel. The packet's last flit frees the channel for the cycle after it.

    Parameters
    ----------
    bits
        Of the data of a flit.
    channels
        Of the link.
    sources
        Number of queues that send here, at least 1.
    depth
        Capacity of the queues behind the channels.
    single_cycle
        A flit passes the crossbar in the cycle of its grant, or else in the next one.
    policy
        Arbitration policy; a flit waits from the cycle on in which it is at the head of its queue.

    Members
    -------
    heads : In, ``sources`` structs of ``valid``, ``first``, ``last``, ``channel``
        Of each queue: whether its head is to leave here, on which channel, and whether it is its packet's first or
        last flit.
    grant : Out(sources)
        The queue whose head leaves.
    data : In, ``sources`` times ``bits``
        Data of the flit that leaves, or that left in the cycle before.
    i_credit : In(channels)
        Credit return of each channel.
    o : Out, stream of `link`, always ready
        The link.
    stalls : Out(1)
        Flits wait for this port and none of them is eligible.

    Timing
    ------
    Latency: ``2 - single_cycle`` cycles from ``heads`` to ``o``. One flit per cycle.
    """

    def __init__(self, *, bits: int, channels: int, sources: int, depth: int, single_cycle: bool = False,
                 policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        self._policy, self._single_cycle = policy, single_cycle
        self._channels, self._sources, self._depth = channels, sources, depth
        head = StructLayout({"valid": 1, "first": 1, "last": 1, "channel": range(channels)})
        super().__init__({
            "heads": In(ArrayLayout(head, sources)), "grant": Out(sources), "data": In(ArrayLayout(bits, sources)),
            "i_credit": In(channels), "o": Out(stream.Signature(link(bits, channels), always_ready=True)),
            "stalls": Out(1)})
        self.latency = 1 if single_cycle else 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.arbiter = arbiter = self._policy.rule(count=self._sources)
        free, has_credit = Signal(self._channels, init=-1), Signal(self._channels)
        grant = arbiter.grant
        for k, head in enumerate(self.heads):
            eligible = [(head.channel == channel) & has_credit[channel] & (free[channel] | ~head.first)
                        for channel in range(self._channels)]
            m.d.comb += [arbiter.request[k].eq(head.valid), arbiter.eligible[k].eq(head.valid & Cat(eligible).any())]
        m.d.comb += [arbiter.accept.eq(arbiter.eligible.any()), self.grant.eq(grant),
                     self.stalls.eq(arbiter.request.any() & ~arbiter.accept)]

        for channel in range(self._channels):
            credits = Signal(range(self._depth + 1), init=self._depth, name=f"credits_{channel}")
            used = Cat(grant[k] & (head.channel == channel) for k, head in enumerate(self.heads)).any()
            ends = Cat(grant[k] & head.last for k, head in enumerate(self.heads)).any()
            m.d.comb += has_credit[channel].eq(credits != 0)
            count_entries(self._depth - credits)
            count_steps(m, credits, up=self.i_credit[channel], down=used, most=self._depth)
            with m.If(used):
                m.d.sync += free[channel].eq(ends)

        claim(m, (grant & (grant - 1)) == 0, "one queue sends")
        # The flit in the crossbar, now or in the next cycle.
        domain = m.d.comb if self._single_cycle else m.d.sync
        crosses, source = Signal(), Signal(range(self._sources), reset_less=True)
        crossing = Signal.like(self.o.payload, reset_less=True)
        domain += [crosses.eq(arbiter.accept), source.eq(self._select(grant, range(self._sources))),
                   crossing.flit.first.eq(self._select(grant, [head.first for head in self.heads])),
                   crossing.flit.last.eq(self._select(grant, [head.last for head in self.heads])),
                   crossing.channel.eq(self._select(grant, [head.channel for head in self.heads]))]
        sent = Signal.like(self.o.payload, reset_less=True)
        # There is no slack for encoding the grant as a number.
        data = self._select(grant, self.data) if self._single_cycle else self.data[source]
        m.d.comb += self.o.payload.eq(sent)
        m.d.sync += [sent.eq(crossing), sent.flit.data.eq(data), self.o.valid.eq(crosses)]
        return m

    @staticmethod
    def _select(grant, values):
        """The value of the granted source."""
        chosen = 0
        for k, value in enumerate(values):
            chosen = chosen | Mux(grant[k], value, 0)
        return chosen
