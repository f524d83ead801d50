"""Main memory port: reads and writes of any length as bursts of AXI4, within windows."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import count_entries, count_steps
from hw.lib.first_fault import FirstFault
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.burst_splitter import BurstSplitter
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.read_engine import ReadEngine
from hw.memsys.port.window_check import WindowCheck
from hw.memsys.port.write_engine import WriteEngine

__all__ = ["MainMemoryPort"]

INCR, UNPRIVILEGED = 1, 0b010
# Normal memory, bufferable and non-cacheable: no cache keeps what a host has changed.
BUFFERABLE = 0b0011


class MainMemoryPort(wiring.Component):
    """All accesses to main memory, as an AXI4 manager.

    No transaction is issued for a request outside its window: it is answered with errors, in order. So is one that
    memory answers with an error, or not at all: every request gets all its beats, and none waits for ever.

    ::

        i_read  -> WindowCheck -> BurstSplitter -> ReadEngine  -> o_read            AXI: AR, R
        i_write -> WindowCheck -> BurstSplitter -> WriteEngine -> o_written              AW, W, B
        i_write_data ------------------------------^

    Parameters
    ----------
    config
        The configuration; ``memory`` has the widths and depths.
    tag
        Shape of a sideband value of a request.

    Members
    -------
    i_read : In, stream of `MemoryFormats.request`
        Reads.
    o_read : Out, stream of `MemoryFormats.reply`
        Their beats in order, request by request.
    i_write : In, stream of `MemoryFormats.request`
        Writes. Reads and writes are independent.
    i_write_data : In, stream of `MemoryFormats.write_data`
        Their beats in order.
    o_written : Out, stream of `MemoryFormats.written`
        One for each write.
    read_window, write_window : In(MemoryFormats.window)
        ``base`` <= address < ``limit``. Stable while ``busy``.
    busy : Out(1)
        A request has not been answered in full, or data of a write have not come.
    fault : Out(MemoryFormats.fault)
        The first fault, until it is cleared.
    clear : In(1)
        Clears it.
    axi : Out, `AxiSignature`
        Main memory.

    Timing
    ------
    Latency: ``5`` cycles from a request to its first address, ``4`` from the last beat of a burst to the first one of
    the reply. One burst per cycle is requested, one beat per cycle in each direction, without a gap between bursts or
    requests; stalls with its clients, with memory, and while ``outstanding`` bursts are in flight.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats = config, MemoryFormats(config)
        formats = self._formats
        super().__init__({
            "i_read": In(stream.Signature(formats.request(tag))), "o_read": Out(stream.Signature(formats.reply(tag))),
            "i_write": In(stream.Signature(formats.request(tag))),
            "i_write_data": In(stream.Signature(formats.write_data)),
            "o_written": Out(stream.Signature(formats.written(tag))),
            "read_window": In(formats.window), "write_window": In(formats.window), "busy": Out(1),
            "fault": Out(formats.fault), "clear": In(1), "axi": Out(AxiSignature(config=config))})
        self._parts = {}
        for name, fault in ("read", Fault.READ_OUTSIDE), ("write", Fault.WRITE_OUTSIDE):
            self._parts[f"{name}_check"] = WindowCheck(config=config, tag=tag, fault=fault)
            # Registered: no combinational path from AXI's ready to the clients.
            self._parts[f"{name}_skid"] = SkidBuffer(formats.checked(tag))
            self._parts[f"{name}_splitter"] = BurstSplitter(config=config, tag=tag)
        self._parts["read_engine"] = ReadEngine(config=config, tag=tag)
        self._parts["write_engine"] = WriteEngine(config=config, tag=tag)
        self.latency = 1 + sum(self._parts[f"read_{name}"].latency for name in ("check", "skid", "splitter"))

    def elaborate(self, platform):
        m = Module()
        for name, part in self._parts.items():
            m.submodules[name] = part
        for name, given in ("read", self.i_read), ("write", self.i_write):
            check, skid, splitter, engine = (
                self._parts[f"{name}_{part}"] for part in ("check", "skid", "splitter", "engine"))
            wiring.connect(m, wiring.flipped(given), check.i)
            wiring.connect(m, check.o, skid.i)
            wiring.connect(m, skid.o, splitter.i)
            wiring.connect(m, splitter.o, engine.i)
            m.d.comb += check.window.eq(getattr(self, f"{name}_window"))
        read, write = self._parts["read_engine"], self._parts["write_engine"]
        wiring.connect(m, read.o, wiring.flipped(self.o_read))
        wiring.connect(m, write.o, wiring.flipped(self.o_written))
        wiring.connect(m, wiring.flipped(self.i_write_data), write.i_data)
        self._add_axi(m, read, write)

        m.submodules.first_fault = first_fault = FirstFault(layout=self.fault.shape(), count=4)
        sources = ("read_check", "write_check", "read_engine", "write_engine")
        for given, part in zip(first_fault.i, sources, strict=True):
            # A stop clears until all is answered: no unit waits for that. Loads and results report their own faults.
            found = self._parts[part].o_fault
            m.d.comb += [given.valid.eq(found.valid & ~self.clear), given.payload.eq(found.payload)]
        m.d.comb += [first_fault.clear.eq(self.clear), self.fault.eq(first_fault.o)]

        # Requests in flight: bursts, and requests before the splitter.
        counts = [Signal(range(self._config.memory.outstanding + 8), name=name) for name in ("reads", "writes")]
        for count, given, answer, ends in (
                (counts[0], self.i_read, self.o_read, self.o_read.payload.last),
                (counts[1], self.i_write, self.o_written, 1)):
            begins, over = given.valid & given.ready, answer.valid & answer.ready & ends
            count_entries(count)
            count_steps(m, count, up=begins, down=over, most=self._config.memory.outstanding + 7)
        m.d.comb += self.busy.eq((counts[0] != 0) | (counts[1] != 0) | write.incomplete)
        return m

    def _add_axi(self, m, read, write):
        """The engines' streams by the standard's names."""
        axi, low = self.axi, self._formats.low_bits
        for channel, stream_ in ("ar", read.o_address), ("aw", write.o_address):
            wires = {name: getattr(axi, f"{channel}{name}") for name in
                     ("id", "addr", "len", "size", "burst", "cache", "prot", "valid", "ready")}
            address = stream_.payload
            m.d.comb += [wires["id"].eq(address.id), wires["addr"].eq(Cat(Const(0, low), address.first)),
                         wires["len"].eq(address.length), wires["size"].eq(low), wires["burst"].eq(INCR),
                         wires["cache"].eq(BUFFERABLE), wires["prot"].eq(UNPRIVILEGED),
                         wires["valid"].eq(stream_.valid), stream_.ready.eq(wires["ready"])]
        data, response, beat = write.o_data, write.i_response, read.i_data
        m.d.comb += [
            axi.wdata.eq(data.payload.data), axi.wstrb.eq(data.payload.strobe), axi.wlast.eq(data.payload.last),
            axi.wvalid.eq(data.valid), data.ready.eq(axi.wready),
            response.payload.id.eq(axi.bid), response.payload.response.eq(axi.bresp),
            response.valid.eq(axi.bvalid), axi.bready.eq(response.ready),
            beat.payload.id.eq(axi.rid), beat.payload.data.eq(axi.rdata), beat.payload.response.eq(axi.rresp),
            beat.payload.last.eq(axi.rlast), beat.valid.eq(axi.rvalid), axi.rready.eq(1)]
