"""The machine in a simulator, as a host reaches it: a third-party AXI4-Lite manager, and a memory model."""

from cocotb.triggers import ClockCycles

from hw.registers.engine_registers import ADDRESS_BITS
from radiosity.flow.host import Port, RegisterError
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.port_monitor import PortMonitor
from tb.memsys.memory_model import MemoryModel

__all__ = ["CocotbPort"]


class CocotbPort(Port):
    """Registers at ``host``, where AXI-Lite's rules are checked, and main memory.

    Parameters
    ----------
    dut, memory
        The engine in the simulator, and the memory at its ``axi``; it can be replaced.
    """

    def __init__(self, dut, memory: MemoryModel):
        from cocotbext.axi import AxiLiteBus, AxiLiteMaster

        self._clock, self.memory = dut.clk, memory
        self.master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "host", bus_separator="__"), dut.clk, dut.rst)
        for half in self.master.write_if, self.master.read_if:
            half.log.setLevel("WARNING")
        PortMonitor(dut, "host", AxiLiteProtocol(ADDRESS_BITS))

    @staticmethod
    def _check(reply, address):
        if int(reply.resp):
            raise RegisterError(f"the register at {address:#x} is answered with {reply.resp.name}")

    async def read(self, address: int) -> int:
        """A register."""
        reply = await self.master.read(address, 4)
        self._check(reply, address)
        return int.from_bytes(reply.data, "little")

    async def write(self, address: int, value: int) -> None:
        """Write a register."""
        self._check(await self.master.write(address, value.to_bytes(4, "little")), address)

    async def read_memory(self, address: int, size: int) -> bytes:
        """Bytes of the model."""
        first = address - self.memory.base
        return bytes(self.memory.data[first:first + size])

    async def write_memory(self, address: int, data: bytes) -> None:
        """Bytes into the model."""
        first = address - self.memory.base
        if not 0 <= first <= len(self.memory.data) - len(data):
            raise ValueError(f"Memory must hold {len(data)} bytes at {address:#x}")
        self.memory.data[first:first + len(data)] = data

    async def wait(self, cycles: int) -> None:
        """Advance the clock by so many cycles."""
        await ClockCycles(self._clock, cycles)
