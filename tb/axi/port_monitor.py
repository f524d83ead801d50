"""A `ProtocolMonitor` at the pins of a component in a simulator."""

import cocotb
from cocotb.triggers import RisingEdge

from tb.axi.protocol_monitor import ProtocolMonitor

__all__ = ["PortMonitor"]


class PortMonitor:
    """Checks every cycle from its construction on. A violation fails the test.

    Parameters
    ----------
    dut
        The component.
    name
        Of the port.
    protocol, rules
        See `ProtocolMonitor`.
    """

    def __init__(self, dut, name: str, protocol, rules: tuple[str, ...] | None = None):
        self._edge, self._reset = RisingEdge(dut.clk), dut.rst
        self._pins = {pin: getattr(dut, f"{name}__{pin}") for pin, width in protocol.pins.items() if width}
        self._controls = [pin for pin in self._pins if pin.endswith(("valid", "ready"))]
        self._payload = {f"{channel}valid": [pin for pin in self._pins if pin.startswith(channel)]
                         for channel in ("aw", "w", "b", "ar", "r")}
        self.monitor = ProtocolMonitor(protocol, rules)
        self._task = cocotb.start_soon(self._run())

    async def _run(self):
        pins, idle = self._pins, dict.fromkeys(self._pins, 0)
        while True:
            await self._edge
            now = idle | {pin: int(pins[pin].value) for pin in self._controls}
            for valid, payload in self._payload.items():
                if now[valid]:
                    now |= {pin: int(pins[pin].value) for pin in payload}
            self.monitor.step(now, reset=int(self._reset.value))

    def stop(self) -> None:
        """End the checks."""
        self._task.cancel()
