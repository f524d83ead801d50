"""Settle map: a conservative floor of each ray's best inverse distance, a tile of rays to a word."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.icu_tables import scale
from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.generations import Generations
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue
from hw.lib.struct_stream import struct_stream
from hw.lib.update_memory import UpdateMemory

__all__ = ["SettleMap"]


class SettleMap(wiring.Component):
    """Codes of the rays, written when a ray has found something nearer, read by the window walk and by survival.

    Each reader has a copy of its own. A code that is read may be outdated, and is too small then, which only costs a
    test: the codes of a frustum never fall. One that is being written is read as 0. A word belongs to the generation in
    which it was written first; the writer keeps the tags too, and gives the other rays of a word that it is the first
    to write code 0.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data of the window walk's reads.

    Members
    -------
    i_start : In, stream without payload
        Begins a frustum: all codes are 0. The sender ensures that no write is in flight, and that no read comes in the
        next three cycles: the last rows of a sweep are still being written.
    tiles : In(range(tiles + 1))
        The tiles of the frustum that begins are below it. Initially all. Stable while ``i_start`` is valid.
    settled : In(1)
        Rays without a code have the largest one, in place of 0. It changes with ``i_start`` alone. Only with
        ``shadow_bits``.
    i : In, stream of ``ray``, ``inverse``, always ready
        A ray and its best inverse distance.
    i_walk : In, stream of ``tag``, ``tile``, always ready
        Reads of the window walk.
    o_walk : Out, stream of ``tag``, ``word``, always ready
        `Formats.settle_word`.
    i_read : In, stream of `Formats.tile`
        Reads of cell traversal.
    o_read : Out, stream of `Formats.settle_word`
        The replies, in order.

    Timing
    ------
    Latency: ``3`` cycles from ``i_walk`` to ``o_walk``, ``4`` from ``i_read`` to ``o_read``; a code can be read
    ``6`` cycles after it was written. One of each per cycle; only ``i_read`` stalls, with ``o_read``. A frustum begins
    ``1`` cycle after ``i_start``. Tiles are swept at reset, and every 2^``generation_bits`` - 1 frusta: then it begins
    when those below ``tiles`` have been swept, one per cycle; the others follow in cycles without a write.

    Golden counterpart: `golden.engine.icu.settle_code`.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats = config, IcuFormats(config)
        formats, tiles = self._formats, config.icu.rays >> 2 * config.icu.tile_bits

        super().__init__({
            "i_start": In(stream.Signature(0)), "tiles": In(range(tiles + 1), init=tiles),
            **({"settled": In(1)} if config.icu.shadow_bits else {}),
            "i": In(struct_stream({"ray": formats.ray, "inverse": formats.inverse})),
            "i_walk": In(struct_stream({"tag": tag, "tile": formats.tile})),
            "o_walk": Out(struct_stream({"tag": tag, "word": formats.settle_word})),
            "i_read": In(stream.Signature(formats.tile)), "o_read": Out(stream.Signature(formats.settle_word))})
        self.latency = 3
        # A register, the writer's latency, and the write.
        self.visible = 6

    def elaborate(self, platform):
        m = Module()
        icu, formats = self._config.icu, self._formats
        lane_bits = 2 * icu.tile_bits
        tiles, lanes = icu.rays >> lane_bits, 1 << lane_bits
        m.submodules.generations = generations = Generations(bits=icu.generation_bits, depth=tiles)
        wiring.connect(m, wiring.flipped(self.i_start), generations.i_start)
        begun = Signal()
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += begun.eq(1)
        m.d.comb += [generations.rows.eq(self.tiles), generations.idle.eq(~begun), generations.busy.eq(self.i.valid)]

        # The code of what is written, and whether its word is of this generation.
        first, cut = scale(self._config)
        code = (self.i.payload.inverse - first) >> cut
        operand = StructLayout({"generation": icu.generation_bits, "clear": 1})
        change = StructLayout({"lane": lane_bits, "code": formats.settle})
        m.submodules.tags = tags = UpdateMemory(
            icu.generation_bits, depth=tiles, operand=operand, tag=change,
            change=lambda _, old, operand: (operand.generation, operand.clear | (old != operand.generation)))
        given = Signal.like(tags.i.payload)
        written = Signal()
        # Whether a row is swept is known later than whether a code comes.
        m.d.sync += [
            written.eq(self.i.valid | generations.sweeps),
            given.address.eq(Mux(self.i.valid, self.i.payload.ray >> lane_bits, generations.row)),
            given.operand.generation.eq(Mux(self.i.valid, generations.generation, 0)),
            given.operand.clear.eq(~self.i.valid), given.tag.lane.eq(self.i.payload.ray[:lane_bits]),
            given.tag.code.eq(Mux(code < 0, 0, Mux(code > icu.settle.high, icu.settle.high, code)))]
        m.d.comb += [tags.i.valid.eq(written), tags.i.payload.eq(given)]

        # The code of a ray without one.
        absent = self.settled.replicate(icu.settle_bits) if icu.shadow_bits else Const(0)
        made = tags.o.payload
        word, lanes_written = Signal(formats.settle_word), Signal(lanes)
        for lane in range(lanes):
            mine = made.tag.lane == lane
            m.d.comb += [word[lane].eq(Mux(mine, made.tag.code, absent)),
                         lanes_written[lane].eq(tags.o.valid & (mine | made.written))]

        def reader(name):
            """A copy: its read ports. What is read of codes that are being written is not used."""
            words = Memory(shape=formats.settle_word, depth=tiles, init=[], attrs={"no_rw_check": 1})
            kept = Memory(shape=icu.generation_bits, depth=tiles, init=[], attrs={"no_rw_check": 1})
            m.submodules[f"{name}_words"], m.submodules[f"{name}_tags"] = words, kept
            write, write_tag = words.write_port(granularity=1), kept.write_port()
            m.d.comb += [write.addr.eq(made.address), write.data.eq(word), write.en.eq(lanes_written),
                         write_tag.addr.eq(made.address), write_tag.data.eq(made.new),
                         write_tag.en.eq(tags.o.valid & made.written)]
            return words.read_port(), kept.read_port()

        # A cycle after the write, when what was read beside it arrives.
        were_written = Signal.like(lanes_written)
        m.d.sync += were_written.eq(lanes_written)
        if icu.shadow_bits:
            was_written = Signal()
            m.d.sync += was_written.eq(tags.o.valid)

        def meets_write(tile):
            return tile == made.address

        # Registered before it selects: the comparison and the many bits of a word are far from each other.
        def is_current(tag, met_write):
            return (tag == generations.generation).replicate(lanes) & ~(were_written & met_write.replicate(lanes))

        # Of a word that is written first all rays are being written.
        def is_absent(tag, met_write):
            return self.settled & (tag != generations.generation) & ~(was_written & met_write)

        def current_codes(codes, current, is_absent):
            return Cat(Mux(current[lane], codes[lane], is_absent.replicate(icu.settle_bits)) for lane in range(lanes))

        ports = reader("walk")
        pipeline = Pipeline(self.i_walk, self.o_walk)
        tile = pipeline.input(self.i_walk.payload.tile)
        codes, tag = (pipeline.read(port, tile) for port in ports)
        meets = pipeline.register(meets_write, tile)
        current = pipeline.register(is_current, tag, meets)
        gone = pipeline.register(is_absent, tag, meets) if icu.shadow_bits else pipeline.constant(Const(0))
        pipeline.output(self.o_walk.payload.word,
                        pipeline.register(current_codes, pipeline.delay(codes, 1), current, gone))
        pipeline.output(self.o_walk.payload.tag, pipeline.input(self.i_walk.payload.tag))
        pipeline.add_to(m)

        self._add_survival(m, reader("survival"), meets_write, is_current, is_absent, current_codes)
        return m

    def _add_survival(self, m, ports, meets_write, is_current, is_absent, current_codes):
        """The reads of cell traversal from the ports of a copy, given what `elaborate` makes of a word and a tag."""
        capacity = 8
        m.submodules.queue = queue = Queue(self._formats.settle_word, depth=capacity)
        wiring.connect(m, queue.o, wiring.flipped(self.o_read))
        outstanding, accepts, ages = Signal(range(capacity + 1)), Signal(), Signal(3)
        m.d.comb += [self.i_read.ready.eq(outstanding != capacity), accepts.eq(self.i_read.valid & self.i_read.ready)]
        returns = queue.o.valid & queue.o.ready
        count_entries(outstanding)
        count_steps(m, outstanding, up=accepts, down=returns, most=capacity)
        claim(m, ~queue.i.valid | queue.i.ready, "a word has an entry")
        m.d.sync += ages.eq((ages << 1) | accepts)
        m.d.comb += [(port.addr.eq(self.i_read.payload), port.en.eq(1)) for port in ports]
        read, found = (Signal(self._formats.settle_word, name=name, reset_less=True) for name in ("read", "found"))
        is_hit, current = Signal(reset_less=True), Signal(1 << 2 * self._config.icu.tile_bits, reset_less=True)
        gone = Signal(reset_less=True) if self._config.icu.shadow_bits else Const(0)
        m.d.sync += [read.eq(ports[0].data), is_hit.eq(meets_write(self.i_read.payload)),
                     current.eq(is_current(ports[1].data, is_hit)), found.eq(current_codes(read, current, gone))]
        if self._config.icu.shadow_bits:
            m.d.sync += gone.eq(is_absent(ports[1].data, is_hit))
        m.d.comb += [queue.i.valid.eq(ages[-1]), queue.i.payload.eq(found)]
