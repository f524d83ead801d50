"""Result address: where the hits of a section go."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.load.serial_product import SerialProduct
from hw.memsys.port.memory_formats import saturated
from hw.memsys.results.result_formats import HitFormat, ResultFormats, lanes_of

__all__ = ["ResultAddress"]


class ResultAddress(wiring.Component):
    """``hits`` of a section = address + bytes (first_row columns + first_column); from row to row its hits skip
    ``columns`` less those of the section.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `ResultFormats.section_command`
        A section that has rays and lies within its frustum.
    o : Out, stream of `ResultFormats.section_extent`
        What `ResultPacker` needs of it.

    Timing
    ------
    Latency: ``3 + bits(first_row)`` cycles. Accepts a command in the cycle before it offers the result; one command in
    flight, another one waits at ``i``; stalls with ``o``.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, ResultFormats(config)
        super().__init__({"i": In(stream.Signature(self._formats.section_command)),
                          "o": Out(stream.Signature(self._formats.section_extent))})
        self.latency = 3 + len(self.i.payload.section.first_row)

    def elaborate(self, platform):
        m = Module()
        command, section, extent = self.i.payload, self.i.payload.section, self.o.payload
        m.submodules.product = product = SerialProduct(
            a=len(command.columns), b=len(section.first_row), addend=len(section.first_column))
        first, skipped = Signal.like(product.o.payload, reset_less=True), Signal.like(command.columns, reset_less=True)
        m.d.comb += [product.i.payload.a.eq(command.columns), product.i.payload.b.eq(section.first_row),
                     product.i.payload.addend.eq(section.first_column)]

        def by_format(full, compact, ids):
            return Mux(command.hit_format == HitFormat.FULL, full, Mux(command.hit_format == HitFormat.IDS, ids,
                                                                       compact))

        # Lanes of a hit, and of what is written of it in a cycle.
        size = by_format(min(4, lanes_of(self._config)), 2, 1)
        with m.FSM():
            with m.State("Begin"):
                m.d.comb += product.i.valid.eq(self.i.valid)
                m.d.sync += skipped.eq(command.columns - section.end_column)
                with m.If(self.i.valid & product.i.ready):
                    m.next = "Multiply"
            with m.State("Multiply"):
                m.d.comb += product.o.ready.eq(1)
                m.d.sync += first.eq(product.o.payload)
                with m.If(product.o.valid):
                    m.d.sync += skipped.eq(skipped + section.first_column)
                    m.next = "Offer"
            with m.State("Offer"):
                m.d.comb += self.i.ready.eq(~self.o.valid)
                with m.If(~self.o.valid):
                    m.d.sync += [
                        self.o.valid.eq(1), extent.hit_format.eq(command.hit_format), extent.sums.eq(command.sums),
                        extent.hits.eq(saturated(command.hits + by_format(first << 4, first << 3, first << 2),
                                                 len(command.hits))),
                        extent.sums_address.eq(command.sums_address), extent.last_column.eq(section.end_column - 1),
                        extent.single.eq(section.first_column + 1 == section.end_column),
                        extent.jump.eq(by_format(skipped << 2, skipped << 1, skipped) + size)]
                    m.next = "Begin"
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        return m
