"""Result words: hits and sums as words of a memory image."""

from amaranth.hdl import Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.image_layout import WORD_BITS
from hw.memsys.result_formats import ResultFormats, ResultKind

__all__ = ["ResultWords"]


class ResultWords(wiring.Component):
    """Two words for each hit, one for each sum, and after the last sum one more: ``total`` less all sums, modulo
    2^`WEIGHT_SUM_BITS`.

    An item that is not the next one is discarded; the words of records that no item belongs to are not enabled.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    command : In(ResultFormats.command)
        Stable from the cycle before ``active`` on.
    active : In(1)
        Items of the command are accepted.
    drained : In(1)
        The writer needs no more words: items that are left over are discarded.
    discard : In(1)
        No word is enabled, as there was a fault.
    i_hit : In, stream of `ResultFormats.hit`
        Hits, up to ``last``.
    i_sum : In, stream of `ResultFormats.sum`
        Sums, up to ``last``.
    o : Out, stream of ``data``, ``enable``
        `WordWriter`'s ``i_word``.
    over : Out(1)
        The last item has been accepted; from then on words that are not enabled fill the extents.
    wrong : Out(1)
        An item was not the next one, or there were too many or too few of them.
    overflow : Out(1)
        A sum has overflowed; its word is not enabled.

    Timing
    ------
    Latency: ``0`` cycles. A hit every two cycles, a sum per cycle; stalls with ``o``.
    """

    latency = 0

    def __init__(self, *, config: Config):
        formats = ResultFormats(config)
        super().__init__({
            "command": In(formats.command), "active": In(1), "drained": In(1), "discard": In(1),
            "i_hit": In(stream.Signature(formats.hit)), "i_sum": In(stream.Signature(formats.sum)),
            "o": Out(stream.Signature(StructLayout({"data": WORD_BITS, "enable": 1}))), "over": Out(1),
            "wrong": Out(1), "overflow": Out(1)})

    def elaborate(self, platform):
        m = Module()
        command, section = self.command, self.command.section
        hit, sum_ = self.i_hit.payload, self.i_sum.payload
        is_sums, word = command.kind == ResultKind.SUMS, self.o
        # The next item; the rest of the total; the second word of a hit.
        column, row = Signal.like(hit.column), Signal.like(hit.row)
        patch, rest, second = Signal(len(sum_.patch) + 1), Signal.like(sum_.sum), Signal()
        comes, matches, extra, takes, last = (Signal(name=name) for name in (
            "comes", "matches", "extra", "takes", "last"))
        # The last column, the patch of the last record, and the one before.
        end_column, end_record, end_patch = Signal.like(hit.column), Signal.like(patch), Signal.like(patch)
        m.d.sync += [end_column.eq(section.end_column - 1), end_record.eq(command["count"] - 1),
                     end_patch.eq(command["count"] - 2)]
        at_end = is_sums & (patch == end_record)
        m.d.comb += [
            comes.eq(self.active & ~self.over & Mux(is_sums, self.i_sum.valid, self.i_hit.valid)),
            last.eq(Mux(is_sums, sum_.last, hit.last)),
            matches.eq(Mux(is_sums, (sum_.patch == patch) & (sum_.last == (patch == end_patch)),
                           (hit.column == column) & (hit.row == row))),
            extra.eq(comes & self.drained), word.valid.eq(comes | self.over),
            word.payload.enable.eq(~self.discard & Mux(self.over, at_end, matches & ~(is_sums & sum_.overflow))),
            self.overflow.eq(takes & is_sums & sum_.overflow),
            takes.eq(extra | (comes & word.ready & (is_sums | second))),
            self.i_hit.ready.eq(takes & ~is_sums), self.i_sum.ready.eq(takes & is_sums),
            # At the end there is a word for each record that no item has come for, and there must be one of sums only.
            self.wrong.eq((takes & (~matches | extra)) | (self.over & word.ready & ~at_end))]
        inverse = Const(0, 32) | hit.hit.inverse
        low = inverse | Mux(hit.hit.inverse != 0, hit.hit.patch, Const(-1, 32))[:32] << 32
        high = hit.hit.u | hit.hit.v << 16
        m.d.comb += word.payload.data.eq(Mux(is_sums, Mux(self.over, rest, sum_.sum), Mux(second, high, low)))
        with m.If(comes & word.ready):
            m.d.sync += second.eq(~second & ~is_sums)
        with m.If(takes):
            m.d.sync += [self.over.eq(last), patch.eq(patch + 1), rest.eq(rest - sum_.sum), column.eq(column + 1)]
            with m.If(column == end_column):
                m.d.sync += [column.eq(section.first_column), row.eq(row + 1)]
        with m.If(self.over & word.ready & is_sums):
            m.d.sync += patch.eq(patch + 1)
        with m.If(~self.active):
            m.d.sync += [column.eq(section.first_column), row.eq(section.first_row), second.eq(0), patch.eq(0),
                         rest.eq(command.total), self.over.eq(0)]
        return m
