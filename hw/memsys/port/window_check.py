"""Window check: keeps requests in the part of memory that the host allows."""

from amaranth.hdl import Cat, Const, Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["WindowCheck"]


class WindowCheck(wiring.Component):
    """``bad`` = not (base <= address and address + bytes <= limit and the address is a multiple of a beat).

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of a sideband value of a request.
    fault
        The fault of a bad request.

    Members
    -------
    window : In(MemoryFormats.window)
        All of its 64 bits count. Stable while a request is in flight.
    i : In, stream of `MemoryFormats.request`
        Requests.
    o : Out, stream of `MemoryFormats.checked`
        All requests, the bad ones too, since they have to be answered.
    o_fault : Out, stream of `MemoryFormats.fault`
        The bad requests. Always ready.

    Timing
    ------
    Latency: ``2`` cycles. One request per cycle; stalls while the request at the end waits.
    """

    def __init__(self, *, config: Config, tag, fault: Fault):
        formats = MemoryFormats(config)
        super().__init__({
            "window": In(formats.window), "i": In(stream.Signature(formats.request(tag))),
            "o": Out(stream.Signature(formats.checked(tag))),
            "o_fault": Out(stream.Signature(formats.fault, always_ready=True))})
        low = formats.low_bits
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        address, length, sideband = (pipeline.input(self.i.payload[name]) for name in ("address", "length", "tag"))
        base, limit = pipeline.constant(self.window.base), pipeline.constant(self.window.limit)
        top = config.memory.address_bits
        # Bits above an address in memory: past its end is past every limit, and a limit past it is none.
        last, misaligned, below = pipeline.register(
            lambda address, length, base: (address[low:] + length, address[:low].any(), address < base),
            address, length, base)
        bad = pipeline.register(
            lambda last, limit, misaligned, below: (
                last[formats.beat_bits:].any() | misaligned | below
                | ~limit[top:].any() & (Cat(Const(-1, low), last[:formats.beat_bits]) >= limit[:top])),
            last, limit, misaligned, below)
        first = pipeline.combine(lambda address: address[low:top], address)
        for name, value in (("first", first), ("tag", sideband), ("bad", bad)):
            pipeline.output(self.o.payload[name], value)
        pipeline.output(self.o.payload.last, pipeline.combine(lambda last: last[:formats.beat_bits], last))
        self._low, self._fault, self.latency = low, fault, pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.d.comb += [self.o_fault.valid.eq(self.o.valid & self.o.ready & self.o.payload.bad),
                     self.o_fault.payload.code.eq(self._fault),
                     self.o_fault.payload.address.eq(Cat(Const(0, self._low), self.o.payload.first))]
        self._pipeline.add_to(m)
        return m
