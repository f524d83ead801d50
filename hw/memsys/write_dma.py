"""Write DMA: what the machine has found out, into a memory image."""

from amaranth.hdl import Const, Module, Mux, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.table_check import COUNT_BITS
from hw.memsys.word_writer import WordWriter

__all__ = ["ResultKind", "WriteDma"]

HIT_WORDS, HIT_BYTES_BITS = 2, 4


class ResultKind(enum.Enum, shape=1):
    """What is written: the hits of a section, or the sums of all patches."""

    HITS = 0
    SUMS = 1


class WriteDma(wiring.Component):
    """Hits and sums to their places in the regions ``hits`` and ``sums``.

    Hit of (column, row): record row x columns + column. Sum of patch p: record p; the record after the last patch is
    what is left of ``total``, which is what the rays that hit nothing have.

    A command takes all that is given up to ``last``. What has no place ends it with `Fault.PLACE`: a section that is
    no part of the frustum, hits in another order than row by row, more or fewer of them, or sums of other patches than
    the region is for. With the first thing that is wrong nothing more is written; beside the region nothing ever is.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``kind``; ``address`` and ``count`` of the region; ``columns`` of the frustum and ``section`` (hits);
        ``total`` (sums).
    i_hit
        ``column``, ``row``, ``hit``, ``last``: those of `ReadOut`.
    i_sum
        ``patch``, ``sum``, ``last``: those of `Collector`.
    o_done
        `MemoryFormats.fault`, one for each command, when memory has answered; with the region's address.
    o_request, o_data, i_written
        `MainMemoryPort`'s ``i_write``, ``i_write_data`` and ``o_written``.

    Timing
    ------
    Latency: ``side_bits + 5`` cycles from a command to its first request. A hit every two cycles, also from row to row
    of more than four, and a sum per cycle; stalls with ``o_data`` and ``o_request``.

    Golden counterpart: `golden.memory_map.MemoryImage.with_results`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats, self._memory = config, IcuFormats(config), MemoryFormats(config)
        formats, address = self._formats, config.memory.address_bits
        super().__init__({
            "i": In(stream.Signature(StructLayout({
                "kind": ResultKind, "address": address, "count": COUNT_BITS, "columns": formats.count,
                "section": formats.section, "total": formats.weight_sum}))),
            "i_hit": In(stream.Signature(StructLayout({"column": formats.index, "row": formats.index,
                                                       "hit": formats.hit, "last": 1}))),
            "i_sum": In(stream.Signature(StructLayout({"patch": formats.patch, "sum": formats.weight_sum, "last": 1}))),
            "o_done": Out(stream.Signature(self._memory.fault)),
            "o_request": Out(stream.Signature(self._memory.request(0))),
            "o_data": Out(stream.Signature(self._memory.write_data)),
            "i_written": In(stream.Signature(self._memory.written(0)))})
        self._writer = WordWriter(config=config)
        # A command, a product of as many bits as a count has, and what comes before a request.
        self.latency = len(Signal(formats.count)) + 3 + self._writer.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.writer = writer = self._writer
        wiring.connect(m, writer.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, writer.o_data, wiring.flipped(self.o_data))
        self._command = Signal.like(self.i.payload, reset_less=True)
        # Places for all have been asked for; all has been given.
        self._placed, self._over = Signal(), Signal()
        self._works, self._code = Signal(), Signal(Fault)
        # Requests that memory has not answered.
        pending = Signal(range(self._config.memory.outstanding + 16))
        asks, answers = self.o_request.valid & self.o_request.ready, self.i_written.valid & self.i_written.ready
        m.d.comb += [self.i_written.ready.eq(1), self.o_done.payload.code.eq(self._code),
                     self.o_done.payload.address.eq(self._command.address)]
        m.d.sync += pending.eq(pending + asks - answers)
        with m.If(answers & self.i_written.payload.error):
            self._fail(m, Fault.WRITE_REPLY)
        with m.FSM():
            with m.State("Wait for a command"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [self._command.eq(self.i.payload), self._code.eq(Fault.NONE), self._over.eq(0),
                             self._placed.eq(0)]
                with m.If(self.i.valid):
                    m.d.sync += self._works.eq(1)
                    m.next = "Begin"
            self._add_places(m)
            with m.State("Wait for memory"), m.If(self._over & ~writer.busy & (pending == 0)):
                m.d.sync += self._works.eq(0)
                m.next = "Answer"
            with m.State("Answer"):
                m.d.comb += self.o_done.valid.eq(1)
                with m.If(self.o_done.ready):
                    m.next = "Wait for a command"
        self._add_words(m)
        return m

    def _fail(self, m, code):
        with m.If(self._code == Fault.NONE):
            m.d.sync += self._code.eq(code)

    def _add_places(self, m):
        """Stretches: row by row of the section, or all sums at once."""
        command, writer = self._command, self._writer
        section = command.section
        # The first ray of a row of the frustum, of a row of the section, and the one after that.
        row_start, first, end = (Signal(COUNT_BITS, reset_less=True) for _ in range(3))
        left, term, factor = Signal.like(section.end_row), Signal.like(first), Signal.like(section.first_row)
        step, width = Signal(range(len(factor) + 1)), Signal.like(section.end_column)
        with m.State("Begin"):
            m.d.sync += [row_start.eq(0), term.eq(command.columns), factor.eq(section.first_row), step.eq(0),
                         width.eq(section.end_column - section.first_column),
                         left.eq(section.end_row - section.first_row)]
            m.next = "Multiply"
            with m.If(command.kind == ResultKind.SUMS):
                m.next = "Ask for the sums"
            with m.Elif((section.first_column >= section.end_column) | (section.end_column > command.columns)
                        | (section.first_row >= section.end_row)):
                self._fail(m, Fault.PLACE)
                m.next = "Stop"
        with m.State("Multiply"):
            m.d.sync += [term.eq(term << 1), factor.eq(factor >> 1), step.eq(step + 1)]
            with m.If(factor[0]):
                m.d.sync += row_start.eq(row_start + term)
            with m.If(step == len(factor) - 1):
                m.next = "Locate a row"
        with m.State("Locate a row"):
            m.d.sync += [first.eq(row_start + section.first_column), end.eq(row_start + section.end_column)]
            m.next = "Ask for a row"
        with m.State("Ask for a row"):
            m.d.comb += [writer.i.payload.address.eq(command.address + (first << HIT_BYTES_BITS)),
                         writer.i.payload.length.eq((width << 1) - 1), writer.i.valid.eq(end <= command.count)]
            with m.If(end > command.count):
                self._fail(m, Fault.PLACE)
                m.next = "Stop"
            with m.Elif(writer.i.ready):
                m.d.sync += [row_start.eq(row_start + command.columns), left.eq(left - 1)]
                m.next = "Locate a row"
                with m.If(left == 1):
                    m.next = "Stop"
        with m.State("Ask for the sums"):
            m.d.comb += [writer.i.payload.address.eq(command.address), writer.i.payload.length.eq(command.count - 1),
                         writer.i.valid.eq(command.count > 1)]
            with m.If(command.count <= 1):
                self._fail(m, Fault.PLACE)
                m.next = "Stop"
            with m.Elif(writer.i.ready):
                m.next = "Stop"
        with m.State("Stop"):
            m.d.sync += self._placed.eq(1)
            m.next = "Wait for memory"

    def _add_words(self, m):
        """What is given, as words; without a place it is dropped, and a place without it is left as it is."""
        command, writer, section = self._command, self._writer, self._command.section
        hit, sum_ = self.i_hit.payload, self.i_sum.payload
        is_sums = command.kind == ResultKind.SUMS
        column, row = Signal.like(hit.column), Signal.like(hit.row)
        patch, rest = Signal(len(sum_.patch) + 1), Signal.like(sum_.sum)
        second, right, drops, takes, last = (Signal(name=name) for name in
                                             ("second", "right", "drops", "takes", "last"))
        comes = Signal()
        # The last column, and the patch of the last record and of the one before.
        end_column, end_record, end_patch = Signal.like(hit.column), Signal.like(patch), Signal.like(patch)
        m.d.sync += [end_column.eq(section.end_column - 1), end_record.eq(command.count - 1),
                     end_patch.eq(command.count - 2)]
        found = hit.hit.inverse != 0
        word = writer.i_word
        with m.If(~self._works):
            m.d.sync += [column.eq(self.i.payload.section.first_column), row.eq(self.i.payload.section.first_row),
                         second.eq(0), patch.eq(0), rest.eq(self.i.payload.total)]
        m.d.comb += [
            comes.eq(self._works & ~self._over & Mux(is_sums, self.i_sum.valid, self.i_hit.valid)),
            last.eq(Mux(is_sums, sum_.last, hit.last)),
            right.eq(Mux(is_sums, (sum_.patch == patch) & (sum_.last == (patch == end_patch)),
                         (hit.column == column) & (hit.row == row))),
            drops.eq(comes & self._placed & ~writer.busy),
            # After the last sum comes the rest; places beyond that are left as they are.
            word.valid.eq(comes | self._over),
            word.payload.counts.eq((self._code == Fault.NONE) & (self._over & is_sums & (patch == end_record)
                                                                 | ~self._over & right)),
            takes.eq(drops | (comes & word.ready & (is_sums | second))),
            self.i_hit.ready.eq(takes & ~is_sums), self.i_sum.ready.eq(takes & is_sums)]
        inverse = Const(0, 32) | hit.hit.inverse
        low = inverse | Mux(found, hit.hit.patch, Const(-1, 32))[:32] << 32
        high = hit.hit.u | hit.hit.v << 16
        m.d.comb += word.payload.data.eq(Mux(is_sums, Mux(self._over, rest, sum_.sum), Mux(second, high, low)))
        with m.If(comes & word.ready):
            m.d.sync += second.eq(~second & ~is_sums)
        with m.If(takes):
            m.d.sync += [self._over.eq(last), patch.eq(patch + 1), rest.eq(rest - sum_.sum), column.eq(column + 1)]
            with m.If(column == end_column):
                m.d.sync += [column.eq(section.first_column), row.eq(row + 1)]
            with m.If(~right | drops):
                self._fail(m, Fault.PLACE)
        # Too few of them: places are left over.
        with m.If(self._over & word.ready & ~(is_sums & (patch == end_record))):
            self._fail(m, Fault.PLACE)
        with m.If(self._over & word.ready & is_sums):
            m.d.sync += patch.eq(patch + 1)
