"""A monitor of a protocol's rules, for benches in Python."""

from types import SimpleNamespace

from tb.axi.channels import PYTHON

__all__ = ["ProtocolError", "ProtocolMonitor"]


class ProtocolError(AssertionError):
    """A rule is violated."""


class ProtocolMonitor:
    """The rules as `ProtocolChecker` has them, cycle by cycle.

    Parameters
    ----------
    protocol
        `AxiProtocol` or `AxiLiteProtocol`.
    rules
        Names of the rules whose violation is an error; default: all.

    Members
    -------
    rules
        The parameter; it may be replaced between cycles.
    cycles
        Cycles in which something was offered.
    """

    def __init__(self, protocol, rules: tuple[str, ...] | None = None):
        self._protocol = protocol
        self.rules = frozenset((*protocol.manager, *protocol.subordinate) if rules is None else rules)
        self._valid = tuple(name for name in protocol.pins if name.endswith("valid"))
        self.cycles = 0
        self._reset()

    def _reset(self):
        self._state = {name: [init for _, init in words] for name, words in self._protocol.state.items()}
        self._quiet = False

    def violated(self, pins: dict[str, int], *, reset: int = 0) -> list[str]:
        """Names of the rules that the next cycle violates; payloads without ``valid`` may be anything.

        Parameters
        ----------
        pins
            By name.
        reset
            Of the port.
        """
        offered = any(pins[name] for name in self._valid)
        found = []
        # After a cycle without an offer the state stays.
        if offered or not self._quiet:
            violated, self._state = self._protocol.step(SimpleNamespace(**{**pins, "reset": reset}), self._state,
                                                         PYTHON)
            found = [name for name, value in violated.items() if value]
        self._quiet = not offered
        self.cycles += offered
        if reset:
            self._reset()
        return found

    def step(self, pins: dict[str, int], *, reset: int = 0) -> None:
        """Check the next cycle, given as to `violated`.

        Raises
        ------
        ProtocolError
            A rule is violated.
        """
        wrong = [name for name in self.violated(pins, reset=reset) if name in self.rules]
        if wrong:
            raise ProtocolError(f"AXI: {', '.join(wrong)}: {pins}")
