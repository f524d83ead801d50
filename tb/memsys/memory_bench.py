"""A component with an AXI4 port `axi` in the simulator, and a `MemoryModel` at it."""

import cocotb
from cocotb.triggers import RisingEdge

from tb.axi.axi_protocol import AxiProtocol
from tb.axi.protocol_monitor import ProtocolMonitor
from tb.memsys.memory_model import MemoryModel

__all__ = ["ModelAtPort"]

_PINS = ("arid", "araddr", "arlen", "arsize", "arburst", "arcache", "arprot", "arvalid", "awid", "awaddr", "awlen",
         "awsize", "awburst", "awcache", "awprot", "awvalid", "wdata", "wstrb", "wlast", "wvalid", "rready", "bready")


class ModelAtPort:
    """Moves the pins, cycle by cycle, and checks AXI's rules; of a faulty memory those of the component alone.

    Parameters
    ----------
    dut
        The component.
    model
        The memory.
    name
        Of the port.

    Members
    -------
    monitor
        Checks the rules.
    """

    def __init__(self, dut, model: MemoryModel, *, name: str = "axi"):
        self._edge, self._model, self._reset = RisingEdge(dut.clk), model, dut.rst
        self._protocol = AxiProtocol(model.config)
        self.monitor = ProtocolMonitor(self._protocol)
        self._wires = {pin: getattr(dut, f"{name}__{pin}") for pin in (*_PINS, *model.out)}
        self._set(model.out)
        self._task = cocotb.start_soon(self._run())

    def _set(self, pins):
        for pin, value in pins.items():
            self._wires[pin].value = value

    async def _run(self):
        wires = self._wires
        valid = [wires[f"{channel}valid"] for channel in ("ar", "aw", "w")]
        idle = dict.fromkeys(_PINS, 0)
        given = dict(self._model.out)
        while True:
            await self._edge
            pins = idle | {"rready": int(wires["rready"].value), "bready": int(wires["bready"].value)}
            # Of what is not valid nothing is looked at.
            for channel, is_valid in zip(("ar", "aw", "w"), valid, strict=True):
                if int(is_valid.value):
                    pins |= {pin: int(wires[pin].value) for pin in _PINS if pin.startswith(channel)}
            if self._model.faulty:
                self.monitor.rules = frozenset(self._protocol.manager)
            self.monitor.step(pins | given, reset=int(self._reset.value))
            out = self._model.step(pins)
            self._set({pin: value for pin, value in out.items() if given[pin] != value})
            given = dict(out)

    def stop(self) -> None:
        """Give nothing more."""
        self._task.cancel()
        self._set(dict.fromkeys(self._model.out, 0))
