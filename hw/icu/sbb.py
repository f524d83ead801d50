"""SBB: the window of azimuths and polar angles that holds a patch seen from a hemisphere's origin."""

from amaranth.hdl import Array, Cat, Const, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import PHASES, IcuFormats, TableKind
from hw.icu.icu_tables import DIAGONAL, EDGES, SAGITTA_BITS, sagitta_table, window_errors
from hw.lib.fixed import extreme, shift_left
from hw.lib.pipeline import Pipeline
from hw.lib.time_multiplexer import TimeMultiplexer

__all__ = ["Sbb"]



class Sbb(wiring.Component):
    """The azimuths of the vertices, in the winding order of the patch, and the polar angles less what
    each edge rises above its lower end; widened by the errors of CORDIC and of the tables.

    In phase e one lane does edge e; another one does the diagonal.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a phase to the next one: a fourth of those from a patch to the next one, at least.

    Members
    -------
    i : In, stream of `IcuFormats.seen`, always ready
        Coordinates of a hemisphere; at least four intervals apart.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of SLACK are stored.
    o : Out, stream of ``slot``, ``window``, always ready
        `Formats.window`.
    frustum : In, `Formats.frustum`
        Stable while patches are in flight.

    Timing
    ------
    Latency: ``2 * ((bits(side_bits) + 1) // 2) + 24 + 3 * interval`` cycles, ``bits(n)`` those of the number n. A patch
    every four intervals; nothing stalls.

    Golden counterpart: `golden.engine.icu.sbb.SphericalWindows`. Source: Shen 1993, Theorem 3.1 and Eq. 3.5.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, icu = IcuFormats(config), config.icu
        super().__init__({
            "i": In(stream.Signature(formats.seen, always_ready=True)),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"slot": formats.slot, "window": formats.window}),
                                      always_ready=True)),
            "frustum": In(formats.frustum)})
        self._sagittas = Memory(shape=SAGITTA_BITS + 1, depth=1 << icu.sagitta_polar_bits + icu.sagitta_span_bits,
                              init=[int(value) for value in sagitta_table(icu).ravel()])
        self._slacks = Memory(shape=icu.angle_bits, depth=1 << icu.side_bits, init=[])
        self._phases = TimeMultiplexer(formats.seen, count=PHASES, interval=interval)
        self._pipeline = pipeline = Pipeline(self._phases.o, self.o, interval=interval)
        bits = icu.angle_bits
        quarter, half = 1 << bits - 2, 1 << bits - 1
        errors = window_errors(config)
        item = self._phases.o.payload.item
        phase = pipeline.input(self._phases.o.payload.phase)
        pipeline.keep(pipeline.combine(lambda phase: phase == PHASES - 1, phase))
        around = [item.signs[edge][2] for edge in range(5)]

        def at_last(value, edge):
            """The value of a phase, as of the last one."""
            return pipeline.before(value, PHASES - 1 - edge)

        turn, reach = self._lane(phase, item, range(4), icu=icu, errors=errors)
        _, across = self._lane(phase, item, [DIAGONAL], icu=icu, errors=errors)
        across = pipeline.register(lambda across, edge, split: Mux(split, across, edge).as_signed(),
                                   across, at_last(reach, 0), pipeline.input(item.winding.split))
        least = extreme(pipeline, [*(at_last(reach, edge) for edge in range(4)), across], largest=False)
        greatest = extreme(pipeline, [pipeline.input(item.second[k]) for k in range(4)], largest=True)

        pole, nadir = pipeline.register(lambda _: _axis_inside(around, item.winding.orientation), phase)
        lowest = pipeline.register(lambda least, pole: Mux(pole, 0, least) - errors.polar_slack, least, pole)
        highest = pipeline.register(lambda value: Mux(
            value > quarter - errors.polar, quarter, value + errors.polar) + errors.polar_slack, greatest)

        def index(value, count_bits, unit, last):
            """The first or last index whose angle, (2 i + 1) / 2 of 2^``unit`` cut in 2^``count_bits``, is inside."""
            value = shift_left(pipeline, value, pipeline.constant(count_bits), len(value.value) + icu.side_bits)
            middle = -(1 << unit - 1) if last else (1 << unit - 1) - 1
            return pipeline.register(lambda value: ((value + middle) >> unit).as_signed(), value)

        size_bits = icu.side_bits.bit_length()
        row_bits, column_bits = (self.frustum[name][:size_bits] for name in ("row_bits", "column_bits"))
        rows, columns = self.frustum.rows, self.frustum.columns
        row_first = pipeline.register(lambda value: Mux(value < 0, 0, value), index(lowest, row_bits, bits - 2, False))
        row_last = pipeline.register(lambda value: Mux(value >= rows, rows - 1, value),
                                     index(highest, row_bits, bits - 2, True))
        clipped = pipeline.register(lambda value: Mux(value >= rows, rows - 1, value)[:icu.side_bits], row_first)
        slack = pipeline.delay(pipeline.read(self._slacks.read_port(), clipped), 1)
        slack = pipeline.register(lambda value: value + errors.azimuth, slack)

        walked = [pipeline.combine(lambda value: value[:bits], pipeline.input(item.first[0]))]
        for edge in range(3):
            walked.append(pipeline.register(lambda a, b: a + b, walked[-1], at_last(turn, edge)))
        left = pipeline.register(lambda a, b: a - b, extreme(pipeline, walked, largest=False), slack)
        right = pipeline.register(lambda a, b: a + b, extreme(pipeline, walked, largest=True), slack)
        span = pipeline.register(lambda left, right: right - left, left, right)
        ring = pipeline.register(lambda span, pole, nadir: (span > half) | pole | nadir, span, pole, nadir)
        column_first, column_last = (index(value, column_bits, bits, last)
                                     for value, last in ((left, False), (right, True)))

        def count(first, last):
            return pipeline.register(lambda first, last: last - first + 1, first, last)

        row_count, column_count = count(row_first, row_last), count(column_first, column_last)
        winding = pipeline.input(Cat(item.winding.orientation[0], item.winding.orientation[1]).any())
        some = pipeline.register(lambda rows, across, ring, winding: (rows > 0) & ((across > 0) | ring) & winding,
                                 row_count, column_count, ring, winding)
        window = self.o.payload.window
        mask = (1 << icu.side_bits) - 1
        for name, value in (
                ("row_first", pipeline.register(lambda some, value: Mux(some, value, 0), some, row_first)),
                ("row_count", pipeline.register(lambda some, value: Mux(some, value, 0), some, row_count)),
                ("column_first", pipeline.register(
                    lambda some, ring, value: Mux(some & ~ring, value & (columns - 1) & mask, 0),
                    some, ring, column_first)),
                ("column_count", pipeline.register(
                    lambda some, ring, value: Mux(some, Mux(ring, columns, value), 0), some, ring, column_count))):
            pipeline.output(window[name], value)
        pipeline.output(self.o.payload.slot, pipeline.input(item.slot))
        self.latency = self._phases.latency + (PHASES - 1) * interval + pipeline.latency

    def _lane(self, phase, item, edges, *, icu, errors):
        """Turn and least polar angle of the edges, one per phase."""
        pipeline, bits = self._pipeline, icu.angle_bits
        quarter = 1 << bits - 2

        def pick(values):
            return pipeline.register(lambda phase: Array(values)[phase] if len(values) > 1 else values[0], phase)

        azimuths, polars = ([pick([coordinate[EDGES[edge][end]] for edge in edges]) for end in range(2)]
                            for coordinate in (item.first, item.second))
        sign = pick([item.signs[edge][2] for edge in edges])
        forward = pipeline.register(
            lambda a, b, sign: Mux(sign < 0, a[:bits] - b[:bits], b[:bits] - a[:bits])[:bits], *azimuths, sign)

        def signed_turn(forward, sign):
            # A step against the winding by less than a quarter turn is an error of the angles.
            behind = Mux(sign == 0, forward[-1], forward >= 3 * quarter)
            return Cat(forward, behind).as_signed()

        along = pipeline.register(signed_turn, forward, sign)
        turn = pipeline.register(lambda along, sign: Mux(sign < 0, -along, along).as_signed(), along, sign)
        span = pipeline.register(
            lambda along: (Mux(along < 0, -along, along) + 2 * errors.azimuth) >> bits - 1 - icu.sagitta_span_bits,
            along)
        lower = pipeline.register(lambda a, b: Mux(a < b, a, b).as_signed(), *polars)
        lower = pipeline.register(lambda value: value - errors.polar, lower)
        most = (1 << icu.sagitta_span_bits) - 1

        def address(lower, span):
            part = Mux(lower < 0, 0, Mux(lower >= quarter, Const(quarter - 1, bits), lower[:bits]))
            return Cat(Mux(span > most, most, span)[:icu.sagitta_span_bits],
                       part[bits - 2 - icu.sagitta_polar_bits:bits - 2])

        entry = pipeline.register(address, lower, span)
        sagitta = pipeline.delay(pipeline.read(self._sagittas.read_port(), entry), 1)
        reach = pipeline.register(lambda lower, sagitta: Mux(
            lower < quarter, lower - (sagitta << bits - 2 - SAGITTA_BITS), lower).as_signed(), lower, sagitta)
        return turn, reach

    def elaborate(self, platform):
        m = Module()
        m.submodules.phases, m.submodules.sagittas, m.submodules.slacks = self._phases, self._sagittas, self._slacks
        wiring.connect(m, wiring.flipped(self.i), self._phases.i)
        port, given = self._slacks.write_port(), self.i_table
        m.d.comb += [port.addr.eq(given.payload.index), port.data.eq(given.payload.data),
                     port.en.eq(given.valid & (given.payload.kind == TableKind.SLACK))]
        self._pipeline.add_to(m)
        return m


def _axis_inside(around, orientation):
    """Whether the R frame's z axis meets the patch, upwards and downwards; zero counts as inside."""
    diagonal = around[DIAGONAL]
    triangles = ((around[0], around[1], -diagonal), (diagonal, around[2], around[3]))

    def inside(side):
        return Cat((turn != 0) & Cat(~((edge != 0) & ((edge < 0) ^ (turn < 0) ^ (side < 0))) for edge in edges).all()
                   for edges, turn in zip(triangles, (orientation[0], orientation[1]), strict=True)).any()

    return inside(1), inside(-1)
