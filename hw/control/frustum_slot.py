"""Frustum slot: the next section of a cluster."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.frustum.ray_list import END_BIT, X_BIT, Y_BIT
from hw.control.job_formats import NEAR_INDEX, Bundle, JobFormats, elements
from hw.ctu.ctu_formats import CtuFormats
from hw.icu.icu_formats import LIST_WORD_BITS, IcuFormats
from hw.memsys.results.result_formats import HitFormat

__all__ = ["FrustumSlot"]

# Bits of a cell in a descriptor's near cells.
CELL_BITS = 32


class FrustumSlot(wiring.Component):
    """Stores the numbers of the next section while the present one is cast, and its near cells in the other bank.

    It requests a section when it is empty and the cluster is free for one: once for each section that is sent. A
    section whose last word is void leaves the slot empty, and the cluster has not been served. A cell with more bits
    than those of the scene becomes the highest one: the scene has no such cell. The results of a shadow frustum are the
    words of its list: hits of 8 bytes in a row.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `JobFormats.word`
        Words of a section for this cluster; the number of the cluster has no effect. Always ready.
    free : In(1)
        The cluster can use the next section: `SectionCast`'s ``free``. Not while ``o`` is valid.
    requests : Out(1)
        A request for one more section, for one cycle.
    o : Out, stream of `JobFormats.slot`
        The section; accepted when all units have begun it.
    o_near : Out, stream of `JobFormats.near_pair`
        `NearCellBanks`'s ``i_load``. Always ready.
    o_ray : Out, stream of ``address``, ``entry``, always ready
        `RayList`'s ``i_load``. Only with ``icu.shadow_bits``.

    Timing
    ------
    Latency: ``2`` cycles from the last word to the section, 1 of near cells and rays. One word per cycle.

    Golden counterpart: `golden.engine.jobs.descriptor`.
    """

    latency = 2

    def __init__(self, *, config: Config):
        self._config, self._formats = config, JobFormats(config)
        rays = {"o_ray": Out(stream.Signature(StructLayout({
            "address": config.icu.shadow_bits, "entry": IcuFormats(config).ray_entry}), always_ready=True))}
        super().__init__({
            **(rays if config.icu.shadow_bits else {}),
            "i": In(stream.Signature(self._formats.word, always_ready=True)), "free": In(1), "requests": Out(1),
            "o": Out(stream.Signature(self._formats.slot)),
            "o_near": Out(stream.Signature(self._formats.near_pair, always_ready=True))})

    def elaborate(self, platform):
        m = Module()
        slot, bank = self.o.payload, Signal()
        # Registered and decoded: a word has hundreds of registers.
        word, valid = Signal.like(self.i.payload, reset_less=True), Signal()
        chosen = Signal(NEAR_INDEX + 1)
        m.d.sync += [word.eq(self.i.payload), valid.eq(self.i.valid),
                     *(bit.eq(self.i.valid & (self.i.payload.index == index)) for index, bit in enumerate(chosen))]
        requested, address = Signal(), Signal(self._config.ctu.near_cell_bits - 1)
        held = Signal.like(slot)
        m.d.comb += [slot.eq(held), slot.bank.eq(bank), self.requests.eq(self.free & ~self.o.valid & ~requested)]
        with m.If(self.requests):
            m.d.sync += requested.eq(1)
        numbers, results = held.numbers, held.results
        targets = {name: [held.section[name], results.section[name]] for name in held.section.shape().members}
        targets = {name: [[both[0]], [both[1]]] for name, both in targets.items()}
        targets |= {name: [[numbers[name]]] for name in (
            "source", "rows", "column_bits", "row_bits", "longest_direction")}
        targets |= {name: [list(numbers[name])] for name in ("origin", "grid_origin")}
        targets |= {name: [[entry for line in numbers[name] for entry in line]] for name in ("matrix", "to_global")}
        targets |= {"columns": [[numbers.columns], [results.columns]],
                    "last_shell": [[held.last_shell]], "near_count": [[held.near_cells]]}
        targets |= {name: [[results[name]]] for name in ("hit_format", "sums", "hits", "sums_address")}
        targets |= {"ray_count": [[held.rays]]} if self._config.icu.shadow_bits else {
            "bundle": [[numbers.is_screen]]}
        for field, several in targets.items():
            for target in several:
                for register, (word_index, bits) in zip(target, elements(field), strict=True):
                    with m.If(chosen[word_index]):
                        m.d.sync += register.eq(word.data[bits])

        is_near = self._add_rays(m, chosen, word, held) if self._config.icu.shadow_bits else Const(1)
        # Near cells, in the bank that the present section does not have.
        near, width = self.o_near, CtuFormats(self._config).cell.width
        cells = [Mux(word.data[low + width:low + CELL_BITS].any(), (1 << width) - 1, word.data[low:low + width])
                 for low in (0, CELL_BITS)]
        m.d.comb += [near.valid.eq(chosen[NEAR_INDEX] & is_near), near.payload.bank.eq(bank),
                     near.payload.address.eq(address), near.payload.cells.eq(Cat(*cells))]
        with m.If(near.valid):
            m.d.sync += address.eq(address + 1)
        with m.If(valid & word.last):
            m.d.sync += address.eq(0)
            with m.If(~word.void):
                m.d.sync += self.o.valid.eq(1)
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += [self.o.valid.eq(0), requested.eq(0), bank.eq(~bank)]
        return m

    def _add_rays(self, m, chosen, word, held):
        """The kind of a frustum with a list, and the rays behind its near cells; whether a word is of these cells."""
        (bundle_word, bundle), = elements("bundle")
        (count_word, count), = elements("near_count")
        out, left, address = self.o_ray, Signal(self._config.ctu.near_cell_bits), Signal(self._config.icu.shadow_bits)
        entry = out.payload.entry
        with m.If(chosen[bundle_word]):
            kind = word.data[bundle]
            m.d.sync += [held.numbers.is_screen.eq(kind != Bundle.HEMISPHERE),
                         held.numbers.is_shadow.eq(kind == Bundle.SHADOW)]
            # The words before have the section and the number of rays.
            with m.If(kind == Bundle.SHADOW):
                words = (held.rays + LIST_WORD_BITS - 1) >> LIST_WORD_BITS.bit_length() - 1
                section = held.results.section
                m.d.sync += [held.results.hit_format.eq(HitFormat.COMPACT), section.first_column.eq(0),
                             section.end_column.eq(Mux(held.rays == 0, 1, words)), section.first_row.eq(0),
                             section.end_row.eq(1)]
        m.d.comb += [
            out.valid.eq(chosen[NEAR_INDEX] & (left == 0)), out.payload.address.eq(address),
            *(field.eq(word.data[first:first + len(field)]) for field, first in (
                (entry.x, X_BIT), (entry.y, Y_BIT), (entry.end, END_BIT)))]
        with m.If(chosen[count_word]):
            m.d.sync += [left.eq((word.data[count] + 1) >> 1), address.eq(0)]
        with m.Elif(chosen[NEAR_INDEX]):
            m.d.sync += [left.eq(left - (left != 0)), address.eq(address + (left == 0))]
        return left != 0
