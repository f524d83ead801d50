"""Result packer: hits and sums of a section as beats."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import WEIGHT_BITS
from hw.lib.validate import check_integer
from hw.memsys.port.memory_formats import MemoryFormats, saturated
from hw.memsys.results.result_formats import LANE_BITS, HitFormat, ResultFormats, lanes_of

__all__ = ["ResultPacker"]

LANE_BYTES = LANE_BITS // 8
# Bits of the fields of a hit of 8 bytes: inverse and patch, u and v. The patch of no hit is all ones.
COMPACT_BITS, UV_BITS = 24, 8


class ResultPacker(wiring.Component):
    """Packs hits of 16, 8 or 4 bytes from the section's first one on, then sums of 8 bytes, into beats.

    A beat goes out when the next item belongs into another one. Its request ends with it if the next beat is not the
    one behind it, if it is the last one of an aligned group of 2^``group_bits`` beats, or after the section's last hit
    or sum. A section as wide as its frustum is one extent; so is a narrower one whose rows leave no whole beat between
    them.

    Parameters
    ----------
    config
        The configuration.
    group_bits
        Base-2 logarithm of the most beats of a request, at least 0.

    Members
    -------
    i : In, stream of `ResultFormats.section_extent`
        Accepted when the sums of the section before have been.
    i_hit : In, stream of `ResultFormats.hit`
        The section's hits row by row, up to ``last``; the words of a list as hits of 8 bytes.
    i_sum : In, stream of `ResultFormats.section_sum`
        Its sums, up to ``last``, after the hits; also if they are not written.
    discard : In(1)
        Nothing more of the section is written; its hits and sums are accepted and dropped.
    o : Out, stream of `ResultFormats.beat`
        The beats.
    busy : Out(1)
        Hits or sums of the section are still to come, or its last beat.
    words : Out(patch_bits + 1)
        Sums that have been written; 0 after ``discard``.
    wrong : Out(1)
        The hit that is being accepted is the last one, but not of a row.
    overflow : Out(1)
        The sum that is being accepted should be written, but has overflowed.

    Timing
    ------
    Latency: ``1`` cycle from the last item of a beat to the beat. A hit per cycle, with beats of 64 bits one of 16
    bytes every two cycles; a sum per cycle; stalls with ``o``. A cycle lies between the last sum and the next section.

    Raises
    ------
    TypeError
        ``group_bits`` is no integer.
    ValueError
        ``group_bits`` is out of range.

    Golden counterpart: `golden.engine.jobs.result_formats.result_beats`.
    """

    def __init__(self, *, config: Config, group_bits: int):
        check_integer("Group bits", group_bits, minimum=0)
        self._config, self._group_bits = config, group_bits
        formats = ResultFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.section_extent)), "i_hit": In(stream.Signature(formats.hit)),
            "i_sum": In(stream.Signature(formats.section_sum)), "discard": In(1),
            "o": Out(stream.Signature(formats.beat)), "busy": Out(1), "words": Out(config.icu.patch_bits + 1),
            "wrong": Out(1), "overflow": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        lanes = lanes_of(self._config)
        hit, total, extent = self.i_hit.payload, self.i_sum.payload, Signal.like(self.i.payload, reset_less=True)
        begins, in_hits, in_sums, free = Signal(init=1), Signal(), Signal(), Signal()
        full, second = Signal(), Signal()
        # Of sums is what is packed when it is not of hits: a register of its own for the many bits that it chooses.
        of_sums = Signal(init=1)
        # Of a hit of 16 bytes in beats of 8 the second half follows in the next cycle.
        halves = (extent.hit_format == HitFormat.FULL) & (lanes < 4)
        ends_item = ~halves | second
        takes_hit, takes_sum = in_hits & self.i_hit.valid & free, in_sums & self.i_sum.valid & free
        ends_hits, ends_sums = Signal(), Signal()
        m.d.comb += [
            free.eq(~full | self.o.ready), self.i_hit.ready.eq(in_hits & free & ends_item),
            self.i_sum.ready.eq(in_sums & free), ends_hits.eq(takes_hit & ends_item & hit.last),
            ends_sums.eq(takes_sum & total.last),
            self.wrong.eq(ends_hits & (hit.column != extent.last_column)),
            self.overflow.eq(takes_sum & extent.sums & total.is_sum & total.overflow)]
        # The next hit is the last one of its row: known with the one before.
        ends_row, before_last = Signal(), Signal.like(extent.last_column, reset_less=True)
        with m.If(takes_hit):
            m.d.sync += second.eq(halves & ~second)
            with m.If(ends_item):
                m.d.sync += ends_row.eq(Mux(ends_row, extent.single, hit.column == before_last))
        # One register for each state.
        m.d.comb += self.i.ready.eq(begins)
        with m.If(begins):
            m.d.sync += [extent.eq(self.i.payload), before_last.eq(self.i.payload.last_column - 1),
                         ends_row.eq(self.i.payload.single), begins.eq(~self.i.valid), in_hits.eq(self.i.valid),
                         of_sums.eq(~self.i.valid)]
        with m.If(ends_hits):
            m.d.sync += [in_hits.eq(0), in_sums.eq(1), of_sums.eq(1)]
        with m.If(ends_sums):
            m.d.sync += [in_sums.eq(0), begins.eq(1)]
        m.d.comb += self.busy.eq(in_hits | in_sums | full)

        # What is written in this cycle.
        writes_sum = takes_sum & extent.sums & total.is_sum & ~total.overflow & ~self.discard
        writes = writes_sum | (takes_hit & (extent.hit_format != HitFormat.NONE) & ~self.discard)
        with m.If((self.i.ready & self.i.valid) | self.discard):
            m.d.sync += self.words.eq(0)
        with m.Elif(writes_sum):
            m.d.sync += self.words.eq(self.words + 1)
        number, at, delta = self._add_cursor(m, extent, of_sums, second, ends_row=ends_row,
                                             takes=takes_hit | takes_sum, ends_hits=ends_hits)
        self._add_beat(m, writes, full, number=number, is_last=ends_hits | ends_sums, delta=delta,
                       mask=self._mask(extent, at, of_sums), words=self._words(extent, second, of_sums))
        return m

    def _add_cursor(self, m, extent, of_sums, second, *, ends_row, takes, ends_hits):
        """The beat and the lane of the next item; how many beats farther the one after it is: 0, 1, or 2 for more."""
        lanes = lanes_of(self._config)
        lane_bits = lanes.bit_length() - 1
        bits, at = MemoryFormats(self._config).beat_bits, Signal(lane_bits, reset_less=True)
        number = Signal(bits + 1, reset_less=True)

        # Lanes of what is written in a cycle.
        size = Signal(range(min(4, lanes) + 1))
        m.d.comb += size.eq(Mux(of_sums | (extent.hit_format == HitFormat.COMPACT), 2,
                                Mux(extent.hit_format == HitFormat.FULL, min(4, lanes), 1)))
        jumps = ~of_sums & ends_row & ((extent.hit_format != HitFormat.FULL) | second | (lanes >= 4))
        # Whether a row ends is known last: the sums and what follows from them are made for both cases.
        sums = [at + step[:lane_bits] for step in (size, extent.jump)]
        sum_ = Mux(jumps, sums[1], sums[0])
        with m.If(takes):
            after = number + Mux(jumps, extent.jump, size)[lane_bits:] + sum_[lane_bits]
            m.d.sync += [number.eq(saturated(after, bits)), at.eq(sum_)]
        for begins, address in (self.i.ready, self.i.payload.hits), (ends_hits, extent.sums_address):
            with m.If(begins):
                m.d.sync += Cat(at, number).eq(address[LANE_BYTES.bit_length() - 1:])

        def beats_farther(step, total):
            """The jump is known long before: nothing is compared behind the sum."""
            carry, none, one = total[lane_bits], step[lane_bits:] == 0, step[lane_bits:] == 1
            return Cat(Mux(carry, none, one), ~(none | (one & ~carry)))

        near, far = (beats_farther(*both) for both in zip((size, extent.jump), sums, strict=True))
        return number, at, Mux(jumps, far, near)

    def _mask(self, extent, at, of_sums):
        """The lanes that are written."""
        lanes = lanes_of(self._config)
        single, pair = Const(1, lanes) << at, Const(3, lanes) << Cat(Const(0, 1), at[1:])
        whole = pair if lanes < 4 else Const(15, lanes) << Cat(Const(0, 2), at[2:])
        return Mux(of_sums | (extent.hit_format == HitFormat.COMPACT), pair,
                   Mux(extent.hit_format == HitFormat.FULL, whole, single))[:lanes]

    def _words(self, extent, second, of_sums):
        """What is in each lane of 4, if it is written."""
        hit, total = self.i_hit.payload.hit, self.i_sum.payload
        patch = Mux(hit.inverse != 0, hit.patch, Const(-1, LANE_BITS))[:LANE_BITS]
        inverse, none = Const(0, LANE_BITS) | hit.inverse, Const(0, LANE_BITS)
        compact = Cat(inverse[:COMPACT_BITS], patch[:COMPACT_BITS], (Const(0, UV_BITS) | hit.u)[:UV_BITS],
                      (Const(0, UV_BITS) | hit.v)[:UV_BITS])
        if self._config.icu.shadow_bits:
            compact = Mux(self.i_hit.payload.is_word, self.i_hit.payload.word, compact)
        words = Cat(total.sum, (Const(0, 64 - WEIGHT_BITS) | total.patch)[:64 - WEIGHT_BITS])
        full = [inverse, patch, (Const(0, LANE_BITS) | hit.u | hit.v << 16)[:LANE_BITS], none]
        if lanes_of(self._config) < 4:
            full = [Mux(second, full[2], full[0]), Mux(second, full[3], full[1])]
        return [Mux(of_sums, words.word_select(k % 2, LANE_BITS),
                    Mux(extent.hit_format == HitFormat.COMPACT, compact.word_select(k % 2, LANE_BITS),
                        Mux(extent.hit_format == HitFormat.FULL, whole, patch))) for k, whole in enumerate(full)]

    def _add_beat(self, m, writes, full, *, number, is_last, delta, mask, words):
        """The beat that is being filled, and offered when it is ``full``."""
        beat, begun = self.o.payload, Signal()
        data = Signal.like(beat.data, reset_less=True)
        kept = Signal.like(beat.lanes, reset_less=True)
        m.d.comb += [self.o.valid.eq(full), beat.data.eq(data), beat.lanes.eq(kept)]
        with m.If(self.o.ready):
            m.d.sync += full.eq(0)
        with m.If(writes):
            group = number[:self._group_bits]
            closes = is_last | delta.any()
            m.d.sync += [full.eq(closes), begun.eq(~closes), kept.eq(Mux(begun, kept, 0) | mask),
                         beat.number.eq(number), beat.ends.eq(is_last | delta[1] | (delta[0] & group.all()))]
            for k in range(len(kept)):
                with m.If(mask[k]):
                    m.d.sync += data.word_select(k, LANE_BITS).eq(words[k % len(words)])
        with m.If(self.i.ready):
            m.d.sync += begun.eq(0)
