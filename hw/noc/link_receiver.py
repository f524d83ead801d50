"""Link receiver: flits from a router to its node."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.checks import claim, count_entries
from hw.lib.queue import Queue
from hw.noc.flit import flit, link

__all__ = ["LinkReceiver"]


class LinkReceiver(wiring.Component):
    """A queue for the flits of each kind of message, with credit return.

    Packets of a kind arrive whole on the kind's first channel, so its other channels have no queue here.

    Parameters
    ----------
    bits, channels, messages, depth
        As those of `hw.noc.link_sender.LinkSender`; ``depth`` is the capacity of the queues here.

    Members
    -------
    i : In, stream of `link`, always ready
        The link.
    o_credit : Out(channels * messages)
        Credit return of each channel.
    o : Out, ``messages`` streams of `flit`
        Flits of each kind.

    Timing
    ------
    Latency: ``1`` cycle. One flit per cycle.

    Golden counterpart: the sinks of `golden.engine.noc.network.Network`.
    """

    def __init__(self, *, bits: int, channels: int, messages: int, depth: int):
        self._bits, self._channels, self._messages, self._depth = bits, channels, messages, depth
        super().__init__({
            "i": In(stream.Signature(link(bits, channels * messages), always_ready=True)),
            "o_credit": Out(channels * messages), "o": Out(stream.Signature(flit(bits))).array(messages)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        credit_return = Signal(self._channels * self._messages)
        m.d.comb += self.o_credit.eq(credit_return)
        for kind, output in enumerate(self.o):
            channel = kind * self._channels
            m.submodules[f"queue_{kind}"] = queue = Queue(flit(self._bits), depth=self._depth)
            wiring.connect(m, queue.o, wiring.flipped(output))
            m.d.comb += [queue.i.payload.eq(self.i.payload.flit),
                         queue.i.valid.eq(self.i.valid & (self.i.payload.channel == channel))]
            count_entries(queue.level)
            claim(m, ~queue.i.valid | queue.i.ready, "a flit has an entry")
            m.d.sync += credit_return[channel].eq(output.valid & output.ready)
        return m
