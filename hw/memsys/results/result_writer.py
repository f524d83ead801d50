"""Result writer: the results of one section after the other into main memory."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.port.beat_writer import GROUP_BITS, BeatWriter
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.results.result_address import ResultAddress
from hw.memsys.results.result_formats import ResultFormats
from hw.memsys.results.result_packer import ResultPacker

__all__ = ["ResultWriter"]


class ResultWriter(wiring.Component):
    """Writes hits and sums of a section, and no byte beside them.

    ::

        i -- ResultAddress -.
        i_hit, i_sum -------+- ResultPacker -- BeatWriter -- o_request, o_data
                                                  '--------- i_written

    Hit of (column, row): record row x columns + column from ``hits`` on, of 16, 8 or 4 bytes, or none. Sums: a word for
    each from ``sums_address`` on, the patch above the sum. All hits up to ``last`` are accepted whatever is written of
    them, then all sums up to ``last``: each section has an item of either.

    A write that memory answers with an error ends the section with `Fault.WRITE_REPLY` and the address of the first
    beat of its request; a sum that should be written and has overflowed with `Fault.OVERFLOW` and its patch as the
    address; a last hit that is not the last one of a row with `Fault.NO_RECORD`. After the first fault no request is
    offered; hits and sums are accepted and discarded.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `ResultFormats.section_command`
        Sections that have rays and lie within their frusta. One waits inside while another one is written.
    i_hit : In, stream of `ResultFormats.hit`
        The hits of a section row by row, up to ``last``, from `ReadOut`. The next section's are not accepted before the
        section's ``o_done``.
    i_sum : In, stream of `ResultFormats.section_sum`
        Its sums, up to ``last``, from `PatchSums`.
    o_done : Out, stream of `ResultFormats.section_done`
        One for each command, when memory has answered all its writes. With a fault the number of sums is 0.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_write``: at most 16 beats of an aligned group of 16.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_write_data``. The data of a request wait for its acceptance, then come without a gap.
    i_written : In, stream of `MemoryFormats.written`, always ready
        Its ``o_written``, in the order of the requests.

    Timing
    ------
    Latency: ``4 + bits(first_row)`` cycles from a command to the first hit, if no other is being written. A hit per
    cycle, with beats of 64 bits one of 16 bytes every two cycles; a sum per cycle; stalls with ``o_data`` and
    ``o_request`` when 32 beats or 16 requests wait, and while 16 requests have no answer. ``o_done`` comes 2 cycles
    after the last answer, the next section's first hit is accepted 2 cycles after ``o_done``.

    Golden counterpart: `golden.engine.jobs.result_formats.result_beats`.
    """

    def __init__(self, *, config: Config):
        self._config, formats, memory = config, ResultFormats(config), MemoryFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.section_command)), "i_hit": In(stream.Signature(formats.hit)),
            "i_sum": In(stream.Signature(formats.section_sum)), "o_done": Out(stream.Signature(formats.section_done)),
            "o_request": Out(stream.Signature(memory.request(0))), "o_data": Out(stream.Signature(memory.write_data)),
            "i_written": In(stream.Signature(memory.written(0), always_ready=True))})
        self.latency = 4 + len(self.i.payload.section.first_row)

    def elaborate(self, platform):
        m = Module()
        m.submodules.extents = extents = ResultAddress(config=self._config)
        m.submodules.packer = packer = ResultPacker(
            config=self._config, group_bits=min(GROUP_BITS, self._config.memory.length_bits))
        m.submodules.writer = writer = BeatWriter(config=self._config)
        for source, sink in ((wiring.flipped(self.i), extents.i), (wiring.flipped(self.i_hit), packer.i_hit),
                             (wiring.flipped(self.i_sum), packer.i_sum), (packer.o, writer.i),
                             (writer.o_request, wiring.flipped(self.o_request)),
                             (writer.o_data, wiring.flipped(self.o_data)),
                             (wiring.flipped(self.i_written), writer.i_written)):
            wiring.connect(m, source, sink)
        code, address, fails = self.o_done.payload.code, self.o_done.payload.address, Signal()
        m.d.comb += [
            packer.i.payload.eq(extents.o.payload), self.o_done.payload.sums.eq(packer.words),
            packer.discard.eq(fails), writer.discard.eq(fails)]
        with m.FSM():
            with m.State("Wait for a command"):
                m.d.comb += [packer.i.valid.eq(extents.o.valid), extents.o.ready.eq(packer.i.ready)]
                m.d.sync += [code.eq(Fault.NONE), address.eq(0), fails.eq(0)]
                with m.If(extents.o.valid & packer.i.ready):
                    m.next = "Write"
            with m.State("Write"):
                # The address is kept until there is a fault; of a fault without one it is cleared in the end.
                answer = self.i_written
                with m.If(~fails):
                    m.d.sync += [
                        fails.eq(writer.failed | packer.overflow | packer.wrong),
                        address.eq(Mux(answer.valid & answer.payload.error, writer.address, self.i_sum.payload.patch))]
                    with m.If(writer.failed):
                        m.d.sync += code.eq(Fault.WRITE_REPLY)
                    with m.Elif(packer.overflow):
                        m.d.sync += code.eq(Fault.OVERFLOW)
                    with m.Elif(packer.wrong):
                        m.d.sync += code.eq(Fault.NO_RECORD)
                with m.If(~packer.busy & writer.idle):
                    with m.If((code == Fault.NONE) | (code == Fault.NO_RECORD)):
                        m.d.sync += address.eq(0)
                    m.next = "Answer"
            with m.State("Answer"):
                m.d.comb += self.o_done.valid.eq(1)
                with m.If(self.o_done.ready):
                    m.next = "Wait for a command"
        return m
