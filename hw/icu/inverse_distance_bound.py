"""Inverse distance bound: an upper bound for all rays of a patch's window, and its settle code."""

from amaranth.hdl import Array, Cat, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import PHASES, IcuFormats, TableKind
from hw.icu.icu_tables import BOUND_BITS, scale
from hw.icu.inverse_distance import encode, value_bits
from hw.lib.fixed import magnitude, split_limbs
from hw.lib.pipeline import OPERAND, Pipeline
from hw.lib.time_multiplexer import TimeMultiplexer

__all__ = ["InverseDistanceBound"]



class InverseDistanceBound(wiring.Component):
    """Hemisphere: the length of m from the leading bits of its components, rounded up, times the longest direction.
    Screen: the largest m . d of the window's four corners, which is a sum of the larger products of either axis. In a
    shadow frustum corners are those of the positions, half a step beside the table's entries.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``slot``, ``factor``, ``window``, always ready
        `IcuFormats.factor`, and the `Formats.window` before it is clipped to the section; at least four cycles apart.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of COLUMN and ROW are stored.
    o : Out, stream of ``slot``, ``bound``, ``threshold``, always ready
        `Formats.inverse`, and the threshold: rays with a settle code below it may still improve.
    frustum : In, `Formats.frustum`
        Stable while patches are in flight.

    Timing
    ------
    Latency: ``2 * product_registers + bits(mantissa_bits + direction_fraction + 1) + 31`` cycles, ``bits(n)`` those of
    the number n. A patch every four cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.inverse_distance.bound`, `golden.engine.icu.settle_code.settle_threshold`.
    """

    def __init__(self, *, config: Config):
        formats, numbers, icu = IcuFormats(config), config.numbers, config.icu
        item_layout = StructLayout({"slot": formats.slot, "factor": formats.factor, "window": formats.window})
        super().__init__({
            "i": In(stream.Signature(item_layout, always_ready=True)),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"slot": formats.slot, "bound": formats.inverse,
                                                    "threshold": formats.threshold}), always_ready=True)),
            "frustum": In(formats.frustum)})
        self._tables = {kind: Memory(shape=formats.direction, depth=1 << icu.side_bits, init=[])
                        for kind in (TableKind.COLUMN, TableKind.ROW)}
        self._phases = TimeMultiplexer(item_layout, count=PHASES)
        self._pipeline = pipeline = Pipeline(self._phases.o, self.o)
        item, screen = self._phases.o.payload.item, self.frustum.is_screen
        phase = pipeline.input(self._phases.o.payload.phase)
        pipeline.keep(pipeline.combine(lambda phase: phase == PHASES - 1, phase))
        mantissa, window = item.factor.mantissa, item.window

        def product(a, b):
            return pipeline.product(a, b, registers=icu.product_registers)

        # Phases 0 and 1 read the first and the last of the window's columns, phases 2 and 3 those of its rows.
        def address_of(first, count):
            further = pipeline.register(lambda phase, count: Mux(phase[0] & (count > 0), count - 1, 0), phase,
                                        pipeline.input(count))
            return pipeline.register(lambda first, further: (first + further)[:icu.side_bits], pipeline.input(first),
                                     further)

        column = address_of(window.column_first, window.column_count)
        row = address_of(window.row_first, window.row_count)
        entries = [pipeline.read(self._tables[kind].read_port(), address)
                   for kind, address in ((TableKind.COLUMN, column), (TableKind.ROW, row))]
        if icu.shadow_bits:
            entries = [pipeline.register(
                lambda phase, entry, bits=bits: self._border(phase, entry, bits).as_signed(), phase, entry)
                for bits, entry in zip((self.frustum.column_bits, self.frustum.row_bits), entries, strict=True)]
        else:
            entries = [pipeline.delay(entry, 1) for entry in entries]
        across = pipeline.combine(lambda phase, column, row: Mux(phase[1], row, column).as_signed(), phase, *entries)
        component = pipeline.register(lambda phase: Mux(phase[1], mantissa[1], mantissa[0]).as_signed(), phase)
        high, low = (pipeline.combine(lambda value, k=k: split_limbs(value, OPERAND)[k], component) for k in range(2))
        # In a hemisphere the phases square the leading bits of one component each.
        lost = numbers.mantissa_bits - BOUND_BITS

        def leading(phase):
            values = Array([magnitude(mantissa[axis]) for axis in range(3)] + [mantissa[0][:1] & 0])
            return (values[phase] + ((1 << lost) - 1)) >> lost

        size = pipeline.register(leading, phase)
        a = pipeline.register(lambda size, low: Mux(screen, low, size).as_signed(), size, low)
        b = pipeline.register(lambda size, across: Mux(screen, across, size).as_signed(), size, across)
        low = product(a, b)
        high = product(high, across)

        # Screen.
        whole = pipeline.register(lambda low, high: low + (high << OPERAND), low, high)
        # Of phases 2 and 3, and of 0 and 1 two phases before. There is time for a register behind the comparison.
        previous = pipeline.before(whole, 1)
        is_less = pipeline.register(lambda a, b: a < b, previous, whole)
        larger = pipeline.register(lambda is_less, a, b: Mux(is_less, b, a).as_signed(), is_less, previous, whole)
        larger = (pipeline.before(larger, 2), larger)
        on_screen = pipeline.register(lambda x, y: x + y, *larger)
        on_screen = pipeline.register(lambda value, z: value + (z << numbers.direction_fraction),
                                      on_screen, pipeline.input(mantissa[2]))

        # Hemisphere.
        squares = [pipeline.before(low, PHASES - 1 - count) for count in range(3)]
        square = pipeline.register(lambda a, b, c: (a + b + c)[:2 * BOUND_BITS + 2], *squares)
        length = _ceil_sqrt(pipeline, square)
        length = product(pipeline.combine(lambda value: Cat(value, 0).as_signed(), length),
                         pipeline.constant(Cat(self.frustum.longest_direction, 0).as_signed()))
        length = pipeline.combine(lambda value: (value << lost).as_signed(), length)

        bits = value_bits(numbers) + 1
        value = pipeline.register(lambda a, b: Mux(screen, a, b)[:bits].as_signed(), on_screen, length)
        exponent = pipeline.combine(lambda value: value - numbers.direction_fraction,
                                    pipeline.input(item.factor.exponent))
        bound = encode(pipeline, value, exponent, numbers, up=True)
        pipeline.output(self.o.payload.bound, bound)
        first, cut = scale(config)

        code = pipeline.register(lambda bound: ((bound - first) >> cut) + 1, bound)
        pipeline.output(self.o.payload.threshold, pipeline.register(
            lambda code: Mux(code < 1, 1, Mux(code > icu.settle.high + 1, icu.settle.high + 1, code)), code))
        pipeline.output(self.o.payload.slot, pipeline.input(item.slot))
        self.latency = self._phases.latency + PHASES - 1 + pipeline.latency

    def _border(self, phase, entry, bits):
        """In a shadow frustum the border of the position that has the entry as its middle, on the window's side."""
        fraction = len(entry) - 2
        half = Cat(bits == fraction - k for k in range(fraction)) & self.frustum.is_shadow.replicate(fraction)
        return (entry + Mux(phase[0], half, -half))[:len(entry)]

    def elaborate(self, platform):
        m = Module()
        m.submodules.phases = self._phases
        wiring.connect(m, wiring.flipped(self.i), self._phases.i)
        given = self.i_table
        for kind, table in self._tables.items():
            m.submodules[kind.name.lower()] = table
            port = table.write_port()
            m.d.comb += [port.addr.eq(given.payload.index), port.data.eq(given.payload.data),
                         port.en.eq(given.valid & (given.payload.kind == kind))]
        self._pipeline.add_to(m)
        return m


def _ceil_sqrt(pipeline, value):
    """The smallest number whose square is at least ``value``: a digit per register."""
    steps = len(value.value) // 2
    root, rest = (pipeline.combine(lambda value: value[:1] & 0, value) for _ in range(2))
    for step in range(steps):
        pair = pipeline.combine(lambda value, k=2 * (steps - 1 - step): value[k:k + 2], value)

        def digit(root, rest, pair, step=step):
            rest, trial = Cat(pair, rest), Cat(1, 0, root)
            difference = rest - trial
            fits = ~difference[-1]
            return Cat(fits, root)[:step + 1], Mux(fits, difference, rest)[:step + 3]

        both = pipeline.register(lambda *values: Cat(*digit(*values)), root, rest, pair)
        root = pipeline.combine(lambda both, size=step + 1: both[:size], both)
        rest = pipeline.combine(lambda both, size=step + 1: both[size:], both)
    return pipeline.register(lambda root, some: root + some, root, pipeline.register(lambda rest: rest.any(), rest))
