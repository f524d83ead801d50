"""Burst splitter: requests as bursts that AXI allows."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import claim
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["BurstSplitter"]


class BurstSplitter(wiring.Component):
    """Cuts a request at every multiple of the longest burst.

    The longest burst is a power of two of at most 4 KiB, so no burst crosses a multiple of 4 KiB.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of a sideband value of a request.

    Members
    -------
    i : In, stream of `MemoryFormats.checked`
        Requests.
    o : Out, stream of `MemoryFormats.burst`
        Their bursts in the order of the addresses.

    Timing
    ------
    Latency: ``1`` cycle. One burst per cycle; stalls with ``o``; one request in flight.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats = config, MemoryFormats(config)
        super().__init__({"i": In(stream.Signature(self._formats.checked(tag))),
                          "o": Out(stream.Signature(self._formats.burst(tag)))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        low = self._formats.burst_bits
        # Bursts of one request differ in these bits of their numbers.
        count_bits = max(self._config.memory.length_bits - low, 0) + 1
        # Bursts are numbered like beats; the first one of a request begins at beat ``start``, the others at 0.
        number, start = Signal(self._formats.beat_bits - low, reset_less=True), Signal(low, reset_less=True)
        last_number, end = Signal(count_bits, reset_less=True), Signal(low, reset_less=True)
        ends = number[:count_bits] == last_number
        burst, given = self.o.payload, self.i.payload
        claim(m, ~self.i.valid | ((given.last - given.first)[:len(given.first)] < 1 << self._config.memory.length_bits),
              "a request is no longer than the window check lets through")
        tag, bad = Signal.like(burst.tag, reset_less=True), Signal(reset_less=True)
        m.d.comb += [
            burst.first.eq(Cat(start, number)), burst.length.eq(Mux(ends, end, Const(-1, low)) - start),
            burst.tag.eq(tag), burst.ends.eq(ends), burst.bad.eq(bad),
            self.i.ready.eq(~self.o.valid | (self.o.ready & ends))]
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), Cat(start, number).eq(given.first),
                         Cat(end, last_number).eq(given.last), tag.eq(given.tag), bad.eq(given.bad)]
        with m.Elif(self.o.ready):
            m.d.sync += [number.eq(number + 1), start.eq(0)]
        return m
