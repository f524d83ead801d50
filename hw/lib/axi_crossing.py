"""AXI crossing: carries the channels of AXI4 or AXI4-Lite from one clock domain to another."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.clock_crossing import ClockCrossing

__all__ = ["AxiCrossing"]

_TO_SUBORDINATE, _TO_MANAGER = ("aw", "ar", "w"), ("b", "r")


class AxiCrossing(wiring.Component):
    """The five channels between a manager and a subordinate in different clock domains, each by a `ClockCrossing`.

    Channels keep their order, each by itself: AXI orders none by another.

    Parameters
    ----------
    signature
        From the manager's side, with members by the standard's names.
    manager, subordinate
        The domains. Their resets must overlap for at least three edges of both clocks.

    Members
    -------
    i : In, the signature
        From the manager.
    o : Out, the signature
        To the subordinate.

    Timing
    ------
    As of `ClockCrossing` in each channel: an access crosses twice, once each way.
    """

    def __init__(self, signature: wiring.Signature, *, manager: str, subordinate: str):
        self._crossings = {}
        for channels, source, sink in ((_TO_SUBORDINATE, manager, subordinate), (_TO_MANAGER, subordinate, manager)):
            for channel in channels:
                fields = {name: member.shape for name, member in signature.members.items()
                          if _channel(name) == channel and not name.endswith(("valid", "ready"))}
                self._crossings[channel] = ClockCrossing(StructLayout(fields), source=source, sink=sink)
        super().__init__({"i": In(signature), "o": Out(signature)})

    def elaborate(self, platform):
        m = Module()
        for channel, crossing in self._crossings.items():
            m.submodules[channel] = crossing
            source, sink = (self.i, self.o) if channel in _TO_SUBORDINATE else (self.o, self.i)
            fields = list(crossing.i.payload.shape().members)
            m.d.comb += [
                crossing.i.valid.eq(getattr(source, f"{channel}valid")),
                getattr(source, f"{channel}ready").eq(crossing.i.ready),
                *(crossing.i.payload[name].eq(getattr(source, name)) for name in fields),
                getattr(sink, f"{channel}valid").eq(crossing.o.valid),
                crossing.o.ready.eq(getattr(sink, f"{channel}ready")),
                *(getattr(sink, name).eq(crossing.o.payload[name]) for name in fields)]
        return m


def _channel(name):
    return next(channel for channel in (*_TO_SUBORDINATE, *_TO_MANAGER) if name.startswith(channel))
