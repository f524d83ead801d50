"""The top of a proof: a component and the rules that it keeps."""

from collections.abc import Callable

from amaranth.hdl import Const, Elaboratable, Module, Signal, Value

from tb.formal.negative_control import NegativeControl

__all__ = ["Bench", "transfers"]


def transfers(interface) -> Value:
    """An item of a stream is transferred in this cycle."""
    return interface.valid & interface.ready


class Bench(Elaboratable):
    """A component whose inputs may have any value in any cycle, but for the assumptions of some rules.

    Parameters
    ----------
    rules
        Adds ``Assert``, ``Assume`` and ``Cover`` to a module, given the module, this bench, the component and
        ``parameters``. Each assertion and each cover has a message, its name.
    dut
        The component.
    is_checked
        The component's own rules (`hw.lib.checks`) are assertions too: its neighbours keep theirs.
    """

    def __init__(self, rules: Callable, dut, *, is_checked: bool = True, **parameters):
        self.rules, self.is_checked, self._dut, self._parameters = rules, is_checked, dut, parameters
        self._free = []

    @property
    def name(self) -> str:
        """The rules' name."""
        return self.rules.__name__

    @property
    def ports(self) -> list[Signal]:
        """The component's ports and the free signals, once the bench has been elaborated."""
        ports = [value for _, _, value in self._dut.signature.flatten(self._dut)]
        return [port for port in map(Value.cast, (*ports, *self._free)) if not isinstance(port, Const) and len(port)]

    def free(self, shape, name: str) -> Signal:
        """A signal that may have any value in any cycle."""
        self._free.append(Signal(shape, name=name))
        return self._free[-1]

    def choose(self, m: Module, shape, name: str) -> Signal:
        """A signal that has any one value in all cycles but the first one after a reset."""
        chosen, is_chosen = Signal(shape, name=name), Signal(name=f"{name}_is_chosen")
        m.d.sync += is_chosen.eq(1)
        with m.If(~is_chosen):
            m.d.sync += chosen.eq(self.free(shape, f"any_{name}"))
        return chosen

    def add_faults(self, faults: dict[str, Callable]) -> None:
        """Make some outputs of the component wrong; see `NegativeControl`."""
        self._dut = NegativeControl(self._dut, faults)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = self._dut
        self.rules(m, self, self._dut, **self._parameters)
        return m
