"""Ray list: the rays of a shadow frustum, stored and sent to their places in the ray memory."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import shift_left
from hw.lib.pipeline import Pipeline

__all__ = ["RayList"]


class RayList(wiring.Component):
    """Stores the rays of a section, and sends each with its address: the upper bits of its slopes are its column and
    row.

    A ray beside the section, or one that ends at the largest 1/t, before which nothing is, is sent as no ray.

    Parameters
    ----------
    config
        The configuration, with ``icu.shadow_bits``.

    Members
    -------
    i_load : In, stream of ``address``, ``entry``, always ready
        `IcuFormats.ray_entry` by its number; not while rays are being sent.
    i : In, stream of ``count``
        How many rays to send. Accepted when the previous ones have left.
    o : Out, stream of `IcuFormats.listed_ray`
        The rays; of none, one item that is no ray.
    frustum : In, `Formats.frustum`
        A shadow frustum. Stable while rays are being sent.

    Timing
    ------
    Latency: ``product_registers + 5 + (bits(side_bits) + 1) // 2`` cycles, ``bits(n)`` those of the number n. One ray
    per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.frustum.ray_list`, `golden.engine.icu.window_walk.ray_address`.
    """

    def __init__(self, *, config: Config):
        formats, icu = IcuFormats(config), config.icu
        self._bits = icu.shadow_bits
        super().__init__({
            "i_load": In(stream.Signature(StructLayout({"address": self._bits, "entry": formats.ray_entry}),
                                          always_ready=True)),
            "i": In(stream.Signature(self._bits + 1)), "o": Out(stream.Signature(formats.listed_ray)),
            "frustum": In(formats.frustum)})
        self._memory = Memory(shape=formats.ray_entry, depth=1 << self._bits, init=[])
        self._steps = stream.Signature(StructLayout({"address": self._bits, "is_ray": 1, "last": 1})).create()
        self._pipeline = pipeline = Pipeline(self._steps, self.o)
        step, out, section = self._steps.payload, self.o.payload, self.frustum.section
        entry = pipeline.delay(pipeline.read(self._memory.read_port(), pipeline.input(step.address)), 1)
        tile, inside = [], [pipeline.input(step.is_ray), pipeline.combine(lambda entry: ~entry.end.all(), entry)]
        for name, axis in (("x", "column"), ("y", "row")):
            place = pipeline.combine(lambda entry, name=name: entry[name], entry)
            bits = pipeline.constant(self.frustum[f"{axis}_bits"])
            index = pipeline.combine(lambda value: value[-icu.side_bits:],
                                     shift_left(pipeline, place, bits, len(place.value) + icu.side_bits))
            first, end = section[f"first_{axis}"], section[f"end_{axis}"]
            inside.append(pipeline.register(lambda value, first=first, end=end: (value >= first) & (value < end),
                                            index))
            tile.append(pipeline.register(lambda value, first=first: (value - first)[:icu.side_bits], index))
        side = icu.tile_bits
        base = pipeline.product(pipeline.combine(lambda row: row[side:], tile[1]),
                                pipeline.constant(self.frustum.tiles_across), registers=icu.product_registers)
        pipeline.output(out.ray, pipeline.register(
            lambda base, column, row: Cat(column[:side], row[:side], (base + column[side:])[:icu.ray_bits - 2 * side]),
            base, *tile))
        pipeline.output(out.is_ray, pipeline.register(lambda *parts: Cat(parts).all(), *inside))
        for name in "x", "y", "end":
            pipeline.output(out[name], pipeline.combine(lambda entry, name=name: entry[name], entry))
        pipeline.output(out.last, pipeline.input(step.last))
        self.latency = 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        write, load, steps = self._memory.write_port(), self.i_load, self._steps
        m.d.comb += [write.addr.eq(load.payload.address), write.data.eq(load.payload.entry), write.en.eq(load.valid)]
        self._pipeline.add_to(m)
        busy, address, left, is_ray = Signal(), Signal(self._bits), Signal(self._bits + 1), Signal()
        m.d.comb += [self.i.ready.eq(~busy), steps.valid.eq(busy), steps.payload.address.eq(address),
                     steps.payload.is_ray.eq(is_ray), steps.payload.last.eq(left == 1)]
        with m.If(busy & steps.ready):
            m.d.sync += [address.eq(address + 1), left.eq(left - 1), busy.eq(left != 1)]
        with m.If(self.i.valid & ~busy):
            m.d.sync += [busy.eq(1), address.eq(0), is_ray.eq(self.i.payload != 0),
                         left.eq(Mux(self.i.payload == 0, 1, self.i.payload))]
        return m
