"""Block memory: main memory in the FPGA."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["DECERR", "OKAY", "BlockMemory"]

OKAY, DECERR = 0, 3


class BlockMemory(wiring.Component):
    """An AXI4 subordinate with the bytes of block RAM from address 0 on.

    Bursts are answered one after the other, reads beside writes. Beats beyond the end are answered with DECERR: they
    read as 0, and writes are lost. A read of a beat in the cycle of its write is undefined; AXI orders no read with a
    write that is not answered yet, and the engine reads nothing that it writes.

    Parameters
    ----------
    config
        The configuration.
    data
        The initial value; its length, up to a whole beat, is that of the memory.

    Members
    -------
    axi : In, `AxiSignature`
        The bus.
    i_peek : In, stream of the number of a beat
        Reads without AXI, while no burst is being read.
    o_peek : Out, stream of a beat
        The beat.

    Timing
    ------
    Latency: ``2`` cycles from a read's address to its first beat, ``1`` from ``i_peek`` to ``o_peek`` and from a
    burst's last beat to the answer of a write. One beat per cycle each way, one cycle between bursts; reads stall with
    ``rready`` and ``o_peek``, writes with ``bready``.

    Raises
    ------
    ValueError
        There is no data, or more than addresses.
    """

    latency = 2

    def __init__(self, *, config: Config, data: bytes):
        beat_bytes = config.memory.beat_bytes
        if not 1 <= len(data) <= 1 << config.memory.address_bits:
            raise ValueError(f"Data must be 1 to {1 << config.memory.address_bits} bytes "
                             f"(memory.address_bits), not {len(data)}")
        self._config, self._formats = config, MemoryFormats(config)
        self._init = [int.from_bytes(data[k:k + beat_bytes], "little") for k in range(0, len(data), beat_bytes)]
        beat = self._formats.beat_bits
        super().__init__({"axi": In(AxiSignature(config=config)), "i_peek": In(stream.Signature(beat)),
                          "o_peek": Out(stream.Signature(config.memory.data_bits))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._config.memory.data_bits, depth=len(self._init),
                                              init=self._init, attrs={"no_rw_check": 1})
        self._add_reads(m, memory.read_port())
        self._add_writes(m, memory.write_port(granularity=8))
        return m

    def _inside(self, number):
        return number < len(self._init)

    def _add_reads(self, m, port):
        axi, formats = self.axi, self._formats
        reads, left = Signal(), Signal(8, reset_less=True)
        number, slot = Signal(formats.beat_bits, reset_less=True), Signal(formats.slot_bits, reset_less=True)
        # The port holds its data until the transfer.
        free = (~axi.rvalid | axi.rready) & (~self.o_peek.valid | self.o_peek.ready)
        m.d.comb += [
            axi.arready.eq(~reads), self.i_peek.ready.eq(~reads & free), port.en.eq(free),
            port.addr.eq(Mux(reads, number, self.i_peek.payload)),
            axi.rdata.eq(Mux(axi.rresp == OKAY, port.data, 0)), self.o_peek.payload.eq(port.data)]
        with m.If(free):
            m.d.sync += [axi.rvalid.eq(reads), self.o_peek.valid.eq(self.i_peek.valid & ~reads), axi.rid.eq(slot),
                         axi.rlast.eq(left == 0), axi.rresp.eq(Mux(self._inside(number), OKAY, DECERR))]
            with m.If(reads):
                m.d.sync += [number.eq(number + 1), left.eq(left - 1), reads.eq(left != 0)]
        with m.If(axi.arvalid & axi.arready):
            m.d.sync += [reads.eq(1), number.eq(axi.araddr >> formats.low_bits), left.eq(axi.arlen),
                         slot.eq(axi.arid)]

    def _add_writes(self, m, port):
        axi, formats = self.axi, self._formats
        writes, outside = Signal(), Signal()
        number = Signal(formats.beat_bits, reset_less=True)
        taken, inside = axi.wvalid & writes, self._inside(number)
        m.d.comb += [
            axi.awready.eq(~writes & ~axi.bvalid), axi.wready.eq(writes), port.addr.eq(number),
            port.data.eq(axi.wdata), port.en.eq(Mux(taken & inside, axi.wstrb, 0)),
            axi.bresp.eq(Mux(outside, DECERR, OKAY))]
        with m.If(taken):
            m.d.sync += [number.eq(number + 1), outside.eq(outside | ~inside), writes.eq(~axi.wlast),
                         axi.bvalid.eq(axi.wlast)]
        with m.If(axi.bvalid & axi.bready):
            m.d.sync += axi.bvalid.eq(0)
        with m.If(axi.awvalid & axi.awready):
            m.d.sync += [writes.eq(1), number.eq(axi.awaddr >> formats.low_bits), outside.eq(0),
                         axi.bid.eq(axi.awid)]
