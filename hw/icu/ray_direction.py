"""Ray direction: from a ray's column and row to its direction in the R frame."""

from amaranth.hdl import Cat, Const, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.lib.fixed import round_shift
from hw.lib.pipeline import Pipeline, Staged

__all__ = ["RayDirection", "direction"]


def direction(pipeline: Pipeline, column: Staged, row: Staged, is_screen, *, fraction: int,
              registers: int, slopes: tuple[Staged, ...] | None = None) -> tuple[Staged, ...]:
    """x, y, z of entries of a column table and a row table, see `RayDirection`.

    Parameters
    ----------
    column, row
        Each two numbers of signed 1.``fraction``.
    registers
        Of each multiplier.
    slopes
        x and y of a screen's ray. Default: the first numbers of the entries.
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
    x, y = slopes or (around[0], first)
    return chosen(x, across[0]), chosen(y, across[1]), chosen(one, second)


class RayDirection(wiring.Component):
    """Hemisphere: (sin p cos a, sin p sin a, cos p), the products rounded. Screen: (x, y, 1). Shadow frustum: the same
    with the x and y of the ray in place of those of its column and row.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``column``, ``row``, always ready
        A ray of the frustum; with ``shadow_bits`` also ``ray``, its place in the ray memory.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of COLUMN and ROW are stored.
    o : Out, stream of ``tag``, ``direction``, always ready
        `Formats.direction_vector`.
    is_screen : In(1)
        Stable while rays are in flight.
    i_ray : In, stream of ``ray``, ``x``, ``y``, always ready
        Slopes of the rays of a shadow frustum are stored. Only with ``shadow_bits``, as is ``is_shadow``.
    is_shadow : In(1)
        Stable while rays are in flight; a shadow frustum is a screen too.

    Timing
    ------
    Latency: ``product_registers + 4`` cycles. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.frustum.FrustumRecord.directions`. Source: Shen 1993, Eq. 3.4.
    """

    def __init__(self, *, config: Config, tag):
        formats, fraction = IcuFormats(config), config.numbers.direction_fraction
        self._shadow = config.icu.shadow_bits > 0
        place = {"ray": formats.ray} if self._shadow else {}
        shadow = {"i_ray": In(stream.Signature(StructLayout({"ray": formats.ray, "x": formats.place,
                                                             "y": formats.place}), always_ready=True)),
                  "is_shadow": In(1)} if self._shadow else {}
        super().__init__({
            **shadow,
            "i": In(stream.Signature(StructLayout({"tag": tag, "column": formats.index, "row": formats.index, **place}),
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
        slopes = None
        if self._shadow:
            self._slopes = Memory(shape=ArrayLayout(formats.place, 2), depth=config.icu.rays, init=[])
            given = pipeline.delay(pipeline.read(self._slopes.read_port(), pipeline.input(self.i.payload.ray)), 1)
            # From the middle of the grid in place of its border.
            slopes = tuple(pipeline.register(
                lambda pair, entry, k=k: Mux(self.is_shadow, Cat(pair[k][:-1], ~pair[k][-1]).as_signed(),
                                             entry[0]).as_signed(), given, entry)
                for k, entry in enumerate((column, row)))
        for axis, value in enumerate(direction(
                pipeline, column, row, self.is_screen, fraction=fraction, registers=config.icu.product_registers,
                slopes=slopes)):
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
        if self._shadow:
            m.submodules.slopes = self._slopes
            port, listed = self._slopes.write_port(), self.i_ray.payload
            m.d.comb += [port.addr.eq(listed.ray), port.data[0].eq(listed.x), port.data[1].eq(listed.y),
                         port.en.eq(self.i_ray.valid)]
        self._pipeline.add_to(m)
        return m
