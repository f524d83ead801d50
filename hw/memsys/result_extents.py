"""Result extents: the records that the results of a command belong to."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.image_layout import COUNT_BITS
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.result_formats import ResultFormats, ResultKind
from hw.memsys.serial_product import SerialProduct

__all__ = ["ResultExtents"]

# A hit is two words of 8 bytes.
HIT_BYTES_BITS = 4


class ResultExtents(wiring.Component):
    """Hits: an extent for each row of the section, from record ``row columns + first_column`` on. Sums: one extent.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `ResultFormats.command`
        Accepted after the last extent.
    wrong : Out(1)
        With ``i.ready``: a section that is no part of the frustum, or a region without a record for it.
    o : Out, stream of `MemoryFormats.write_extent`
        For `WordWriter`.

    Timing
    ------
    Latency: ``4 + bits(first_row)`` cycles to the first row of a section. An extent every two cycles; stalls with
    ``o``.
    """

    def __init__(self, *, config: Config):
        super().__init__({"i": In(stream.Signature(ResultFormats(config).command)), "wrong": Out(1),
                          "o": Out(stream.Signature(MemoryFormats(config).write_extent))})

    def elaborate(self, platform):
        m = Module()
        command, section, extent = self.i.payload, self.i.payload.section, self.o.payload
        m.submodules.product = product = SerialProduct(a=len(command.columns), b=len(section.first_row))
        # First ray of a row of the frustum; of the row in the section the first ray and the one after the last.
        row_start, first, end = (Signal(COUNT_BITS, reset_less=True, name=name) for name in (
            "row_start", "first", "end"))
        left, width = Signal.like(section.end_row), Signal.like(section.end_column)
        m.d.comb += [product.i.payload.a.eq(command.columns), product.i.payload.b.eq(section.first_row),
                     extent.address.eq(command.address + (first << HIT_BYTES_BITS)),
                     extent.length.eq((width << 1) - 1)]
        with m.FSM():
            with m.State("Begin"):
                m.d.sync += [width.eq(section.end_column - section.first_column),
                             left.eq(section.end_row - section.first_row)]
                with m.If(self.i.valid):
                    m.next = "Multiply"
                    with m.If(command.kind == ResultKind.SUMS):
                        m.next = "Offer the sums"
                    with m.Elif((section.first_column >= section.end_column) | (section.first_row >= section.end_row)
                                | (section.end_column > command.columns)):
                        m.d.comb += [self.wrong.eq(1), self.i.ready.eq(1)]
                        m.next = "Begin"
                    with m.Else():
                        m.d.comb += product.i.valid.eq(1)
            with m.State("Multiply"):
                m.d.comb += product.o.ready.eq(1)
                m.d.sync += row_start.eq(product.o.payload)
                with m.If(product.o.valid):
                    m.next = "Locate a row"
            with m.State("Locate a row"):
                m.d.sync += [first.eq(row_start + section.first_column), end.eq(row_start + section.end_column)]
                m.next = "Offer a row"
            with m.State("Offer a row"):
                m.d.comb += self.o.valid.eq(end <= command["count"])
                with m.If(end > command["count"]):
                    m.d.comb += [self.wrong.eq(1), self.i.ready.eq(1)]
                    m.next = "Begin"
                with m.Elif(self.o.ready):
                    m.d.sync += [row_start.eq(row_start + command.columns), left.eq(left - 1)]
                    m.next = "Locate a row"
                    with m.If(left == 1):
                        m.d.comb += self.i.ready.eq(1)
                        m.next = "Begin"
            with m.State("Offer the sums"):
                m.d.comb += [extent.address.eq(command.address), extent.length.eq(command["count"] - 1),
                             self.o.valid.eq(command["count"] > 1), self.wrong.eq(command["count"] <= 1)]
                with m.If(self.wrong | self.o.ready):
                    m.d.comb += self.i.ready.eq(1)
                    m.next = "Begin"
        return m
