"""A checker of a protocol's rules, as a component beside a port."""

from types import SimpleNamespace

from amaranth.hdl import Module, ResetSignal, Signal
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from tb.axi.channels import AMARANTH

__all__ = ["ProtocolChecker"]


class ProtocolChecker(wiring.Component):
    """Watches a port; has no influence on it.

    Parameters
    ----------
    protocol
        `AxiProtocol` or `AxiLiteProtocol`.

    Members
    -------
    port : In, all pins of the port as inputs
        The port.
    violated : Out(layout)
        A bit for each rule, by its name: violated in this cycle.

    Timing
    ------
    Latency: ``0`` cycles.
    """

    latency = 0

    def __init__(self, protocol):
        self._protocol = protocol
        super().__init__({
            "port": In(wiring.Signature({name: In(width) for name, width in protocol.pins.items()})),
            "violated": Out(StructLayout(dict.fromkeys((*protocol.manager, *protocol.subordinate), 1)))})

    def watch(self, m: Module, port) -> None:
        """Connect the pins of an interface object."""
        m.d.comb += [getattr(self.port, name).eq(getattr(port, name)) for name in self._protocol.pins]

    def elaborate(self, platform):
        m = Module()
        state = {name: [Signal(width, init=init, name=f"{name}_{k}") for k, (width, init) in enumerate(words)]
                 for name, words in self._protocol.state.items()}
        pins = SimpleNamespace(reset=ResetSignal(), **{name: getattr(self.port, name) for name in self._protocol.pins})
        violated, following = self._protocol.step(pins, state, AMARANTH)
        m.d.comb += [self.violated[name].eq(value) for name, value in violated.items()]
        for name, words in following.items():
            m.d.sync += [word.eq(value) for word, value in zip(state[name], words, strict=True)]
        return m
