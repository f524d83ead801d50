"""A small unit that stands for the engine between its crossings."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import PRESETS
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.memory_formats import MemoryFormats
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.engine_registers import ADDRESS_BITS
from hw.registers.register import Access, Register
from hw.registers.registers import Registers
from tb.axi.axi_protocol import BUFFERABLE, INCR

__all__ = ["CONFIG", "TABLE", "WORD", "Copier"]

CONFIG = PRESETS["tiny"]
TABLE = (Register(name="address", access=Access.WRITE, about="The word there is copied when it changes."),
         Register(name="copied", access=Access.READ, about="The word."),
         Register(name="interrupt", access=Access.WRITE, about="The pin.", width=1))
WORD = CONFIG.memory.data_bits // 8


class Copier(wiring.Component):
    """Copies the word of main memory at the address in its first register to the next one."""

    def __init__(self, *, config, black_boxes):
        super().__init__({"host": In(AxiLiteSignature(address_bits=ADDRESS_BITS)),
                          "axi": Out(AxiSignature(config=config)), "irq": Out(1)})

    def elaborate(self, platform):
        """Registers, and requests of a beat."""
        m = Module()
        m.submodules.registers = registers = Registers(TABLE, address_bits=ADDRESS_BITS)
        wiring.connect(m, wiring.flipped(self.host), registers.host)
        axi, requested = self.axi, Signal(32)
        for channel in "ar", "aw":
            m.d.comb += [getattr(axi, f"{channel}{name}").eq(value) for name, value in (
                ("burst", INCR), ("cache", BUFFERABLE), ("size", MemoryFormats(CONFIG).low_bits))]
        m.d.comb += [axi.arvalid.eq(registers.address != requested), axi.araddr.eq(registers.address),
                     axi.awaddr.eq(requested + WORD), axi.wstrb.eq(-1), axi.wlast.eq(1), axi.rready.eq(1),
                     axi.bready.eq(1), self.irq.eq(registers.interrupt)]
        with m.If(axi.arvalid & axi.arready):
            m.d.sync += requested.eq(registers.address)
        for channel in "aw", "w":
            offered = Signal(name=f"{channel}_offered")
            m.d.comb += getattr(axi, f"{channel}valid").eq(offered)
            with m.If(axi.rvalid):
                m.d.sync += offered.eq(1)
            with m.Elif(getattr(axi, f"{channel}ready")):
                m.d.sync += offered.eq(0)
        with m.If(axi.rvalid):
            m.d.sync += axi.wdata.eq(axi.rdata)
        with m.If(axi.bvalid):
            m.d.sync += registers.copied.eq(axi.wdata)
        return m
