"""Write DMA: the results of a frustum into a memory image."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.result_extents import ResultExtents
from hw.memsys.result_formats import ResultFormats
from hw.memsys.result_words import ResultWords
from hw.memsys.word_writer import WordWriter

__all__ = ["WriteDma"]


class WriteDma(wiring.Component):
    """Writes hits and sums into the regions ``hits`` and ``sums``.

    ::

        i -+- ResultExtents -.
           '- ResultWords ---+- WordWriter - o_request, o_data
        i_hit, i_sum --'

    Hit of (column, row): record row x columns + column. Sum of patch p: record p; the record after the last patch is
    the rest of ``total``, the weight of the rays that hit nothing. ``total`` is not checked: of one that is too
    small the rest is modulo 2^`WEIGHT_SUM_BITS`.

    A command accepts all items up to ``last``. An item without a record ends it with `Fault.NO_RECORD`: a section that
    is no part of the frustum, hits in another order than row by row, more or fewer of them, or sums of other patches
    than the region has. A sum that has overflowed ends it with `Fault.OVERFLOW`. After the first fault nothing more is
    written; nothing is ever written beside the region.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `ResultFormats.command`
        Commands.
    i_hit : In, stream of `ResultFormats.hit`
        From `ReadOut`.
    i_sum : In, stream of `ResultFormats.sum`
        From `Collector`.
    o_done : Out, stream of `MemoryFormats.fault`
        One for each command, when memory has answered; the address is that of the region.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_write``.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_write_data``.
    i_written : In, stream of `MemoryFormats.written`
        Its ``o_written``.

    Timing
    ------
    Latency: ``5 + bits(first_row)`` cycles from a command for hits to its first request. A hit every two cycles, also
    from row to row of more than four, and a sum per cycle; stalls with ``o_data`` and ``o_request``.

    Golden counterpart: `golden.memory_map.MemoryImage.with_results`.
    """

    def __init__(self, *, config: Config):
        self._config, formats, memory = config, ResultFormats(config), MemoryFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.command)), "i_hit": In(stream.Signature(formats.hit)),
            "i_sum": In(stream.Signature(formats.sum)), "o_done": Out(stream.Signature(memory.fault)),
            "o_request": Out(stream.Signature(memory.request(0))), "o_data": Out(stream.Signature(memory.write_data)),
            "i_written": In(stream.Signature(memory.written(0)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.extents = extents = ResultExtents(config=self._config)
        m.submodules.words = words = ResultWords(config=self._config)
        m.submodules.writer = writer = WordWriter(config=self._config)
        for source, sink in ((extents.o, writer.i), (words.o, writer.i_word),
                             (wiring.flipped(self.i_hit), words.i_hit), (wiring.flipped(self.i_sum), words.i_sum),
                             (writer.o_request, wiring.flipped(self.o_request)),
                             (writer.o_data, wiring.flipped(self.o_data))):
            wiring.connect(m, source, sink)
        command, code = Signal.like(self.i.payload, reset_less=True), Signal(Fault)
        # All extents have been requested.
        active, all_requested = Signal(), Signal()
        outstanding = Signal(range(self._config.memory.outstanding + 16))
        requests, answers = self.o_request.valid & self.o_request.ready, self.i_written.valid & self.i_written.ready
        m.d.comb += [
            self.i_written.ready.eq(1), self.o_done.payload.code.eq(code),
            self.o_done.payload.address.eq(command.address), extents.i.payload.eq(command), words.command.eq(command),
            words.active.eq(active), words.drained.eq(all_requested & ~writer.busy),
            words.discard.eq(code != Fault.NONE)]
        m.d.sync += outstanding.eq(outstanding + requests - answers)
        with m.If(code == Fault.NONE):
            with m.If(words.wrong | (extents.wrong & extents.i.ready)):
                m.d.sync += code.eq(Fault.NO_RECORD)
            with m.If(words.overflow):
                m.d.sync += code.eq(Fault.OVERFLOW)
            with m.If(answers & self.i_written.payload.error):
                m.d.sync += code.eq(Fault.WRITE_REPLY)
        with m.FSM():
            with m.State("Wait for a command"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [command.eq(self.i.payload), code.eq(Fault.NONE), all_requested.eq(0)]
                with m.If(self.i.valid):
                    m.next = "Request"
            with m.State("Request"):
                m.d.comb += extents.i.valid.eq(1)
                m.d.sync += active.eq(1)
                with m.If(extents.i.ready):
                    m.d.sync += all_requested.eq(1)
                    m.next = "Drain"
            with m.State("Drain"), m.If(words.over & all_requested & ~writer.busy & (outstanding == 0)):
                m.d.sync += active.eq(0)
                m.next = "Answer"
            with m.State("Answer"):
                m.d.comb += self.o_done.valid.eq(1)
                with m.If(self.o_done.ready):
                    m.next = "Wait for a command"
        return m
