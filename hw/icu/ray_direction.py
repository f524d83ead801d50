"""Ray direction: from a ray's column and row to its direction in the R frame."""

from amaranth.hdl import Const, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.lib.fixed import round_shift
from hw.lib.pipeline import Pipeline, Staged

__all__ = ["RayDirection", "direction"]


def direction(pipeline: Pipeline, column: Staged, row: Staged, is_screen, *, fraction: int,
              registers: int) -> tuple[Staged, ...]:
    """x, y, z of entries of a column table and a row table, see `RayDirection`.

    Parameters
    ----------
    column, row
        Each two numbers of signed 1.``fraction``.
    registers
        Of each multiplier.
    """
    width = fraction + 2
    first, second = (pipeline.combine(lambda pair, k=k: pair[k], row) for k in range(2))
    around = [pipeline.combine(lambda pair, k=k: pair[k], column) for k in range(2)]

    def rounded(product):
        # Of two entries of at most 1: as wide as they are, which is an operand of a multiplier.
        return round_shift(product, fraction)[:width].as_signed()

    across = [pipeline.register(rounded, pipeline.product(first, value, registers=registers))
              for value in around]

    def chosen(screen, hemisphere):
        return pipeline.register(lambda a, b: Mux(is_screen, a, b).as_signed(), screen, hemisphere)

    one = pipeline.constant(Const(1 << fraction, width).as_signed())
    return chosen(around[0], across[0]), chosen(first, across[1]), chosen(one, second)


class RayDirection(wiring.Component):
    """Hemisphere: (sin p cos a, sin p sin a, cos p), the products rounded. Screen: (x, y, 1).

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``column``, ``row``, always ready
        A ray of the frustum.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of COLUMN and ROW are stored.
    o : Out, stream of ``tag``, ``direction``, always ready
        `Formats.direction_vector`.
    is_screen : In(1)
        Stable while rays are in flight.

    Timing
    ------
    Latency: ``product_registers + 4`` cycles. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.frustum.FrustumRecord.directions`. Source: Shen 1993, Eq. 3.4.
    """

    def __init__(self, *, config: Config, tag):
        formats = IcuFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "column": formats.index, "row": formats.index}),
                                     always_ready=True)),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "direction": formats.direction_vector}),
                                      always_ready=True)),
            "is_screen": In(1)})
        self._tables = {kind: Memory(shape=formats.direction_pair, depth=1 << config.icu.side_bits, init=[])
                        for kind in (TableKind.COLUMN, TableKind.ROW)}
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        column, row = (pipeline.delay(pipeline.read(self._tables[kind].read_port(), pipeline.input(index)), 1)
                       for kind, index in ((TableKind.COLUMN, self.i.payload.column),
                                           (TableKind.ROW, self.i.payload.row)))
        for axis, value in enumerate(direction(
                pipeline, column, row, self.is_screen, fraction=config.numbers.direction_fraction,
                registers=config.icu.product_registers)):
            pipeline.output(self.o.payload.direction[axis], value)
        pipeline.output(self.o.payload.tag, pipeline.input(self.i.payload.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        given = self.i_table
        for kind, table in self._tables.items():
            m.submodules[kind.name.lower()] = table
            port = table.write_port()
            m.d.comb += [port.addr.eq(given.payload.index), port.data.eq(given.payload.data),
                         port.en.eq(given.valid & (given.payload.kind == kind))]
        self._pipeline.add_to(m)
        return m
