"""Frustum load: words of a memory image to the tables of the frusta of a phase."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.memsys.load.image_layout import RegionNumber, halves
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["FIRST_SHELL", "FrustumLoad"]

# The first shell that has a record.
FIRST_SHELL = 2


class FrustumLoad(wiring.Component):
    """Routes words to the tables of a cluster's intersection unit and traversal unit, and stores what all frusta of the
    scene share.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `MemoryFormats.table_word`
        Words of this cluster.
    o_table : Out, stream of `IcuFormats.table_write`
        Columns and rows of rays.
    o_grid : Out, stream of `CtuFormats.grid_table_write`
        Grid rays. Always ready.
    o_subshell : Out, stream of ``address``, ``patch``, ``shell``
        `hw.ctu.subshell_table.SubshellTable`'s ``i_load``. Always ready.
    cells : Out(CtuFormats.traversal_frustum["cells"])
        Cells of the scene along each axis.
    subshells : Out(32)
        Listed subshells.

    Timing
    ------
    Latency: ``0`` cycles of a word, 1 of grid rays, 2 of numbers. One word per cycle; stalls with ``o_table``.

    Golden counterpart: `golden.engine.memory_map`.
    """

    latency = 0

    def __init__(self, *, config: Config):
        self._config, self._formats = config, CtuFormats(config)
        formats, subshells = self._formats, config.ctu.subshell_bits
        super().__init__({
            "i": In(stream.Signature(MemoryFormats(config).table_word)),
            "o_table": Out(stream.Signature(IcuFormats(config).table_write)),
            "o_grid": Out(stream.Signature(formats.grid_table_write, always_ready=True)),
            "o_subshell": Out(stream.Signature(StructLayout({"address": subshells, "patch": 32, "shell": 32}),
                                               always_ready=True)),
            "cells": Out(formats.traversal_frustum["cells"].shape), "subshells": Out(32)})

    def elaborate(self, platform):
        m = Module()
        # The last data of each word of a record.
        before = Signal(ArrayLayout(64, 4), reset_less=True)
        with m.If(self.i.valid):
            m.d.sync += before[self.i.payload.word].eq(self.i.payload.data)
        self._add_tables(m)
        self._add_grid(m, before)
        self._add_numbers(m, before)
        return m

    def _add_tables(self, m):
        """Columns and rows of rays; the other outputs are always ready."""
        given, out = self.i.payload, self.o_table.payload
        width = self._formats.direction.width
        pair = Cat(given.data[:width], given.data[32:32 + width])
        # Every word waits: whether it is for a table of rays is known later.
        m.d.comb += [out.index.eq(given.record), self.i.ready.eq(self.o_table.ready)]
        for region, word, kind, data in (
                (RegionNumber.COLUMNS, 0, TableKind.COLUMN, pair), (RegionNumber.ROWS, 0, TableKind.ROW, pair),
                (RegionNumber.ROWS, 1, TableKind.WEIGHT, given.data),
                (RegionNumber.ROWS, 2, TableKind.SLACK, given.data[:32])):
            with m.If((given.region == region) & (given.word == word)):
                m.d.comb += [self.o_table.valid.eq(self.i.valid), out.kind.eq(kind), out.data.eq(data)]

    def _add_grid(self, m, before):
        """Tables of grid rays: a record is written with its last word."""
        formats, given, out = self._formats, self.i.payload, self.o_grid
        low, high = given.data[:32], given.data[32:]

        def half(word, is_high):
            return before[word][32:] if is_high else before[word][:32]

        shell, row, column = (Signal(shape, name=name) for name, shape in (
            ("shell", formats.grid_shell), ("row", formats.grid_row), ("column", formats.grid_column)))
        m.d.comb += [
            shell.begin.eq(half(0, 0)), shell.length.eq(half(0, 1) - half(0, 0)), shell.threshold.eq(half(1, 0)),
            shell.row_border.eq(half(1, 1)), shell.first_row.eq(half(2, 0)), shell.rows.eq(half(2, 1)),
            shell.first_column.eq(half(3, 0)), shell.columns.eq(half(3, 1)), shell.first_ray.eq(low),
            row.table[0].eq(half(0, 0)), row.table[1].eq(half(0, 1)), row.position.eq(half(1, 0)),
            row.first_near.eq(half(1, 1)), row.near.eq(half(2, 0)), row.column_reach.eq(half(2, 1)),
            row.column_border.eq(low),
            column.table[0].eq(half(0, 0)), column.table[1].eq(half(0, 1)), column.position.eq(low)]
        # Registered: a record is decoded before it goes to the tables, which are far from each other.
        m.d.sync += out.valid.eq(0)
        for region, word, kind, record, first in (
                (RegionNumber.SHELLS, 4, GridTableKind.SHELL, shell, FIRST_SHELL),
                (RegionNumber.GRID_ROWS, 3, GridTableKind.ROW, row, 0),
                (RegionNumber.GRID_COLUMNS, 1, GridTableKind.COLUMN, column, 0)):
            with m.If((given.region == region) & (given.word == word)):
                m.d.sync += [out.valid.eq(self.i.valid & self.i.ready), out.payload.kind.eq(kind),
                             out.payload.data.eq(record), out.payload.index.eq(given.record + first)]
        m.d.comb += [
            self.o_subshell.valid.eq(self.i.valid & self.i.ready & (given.region == RegionNumber.SUBSHELLS)
                                     & (given.record >> self._config.ctu.subshell_bits == 0)),
            self.o_subshell.payload.address.eq(given.record), self.o_subshell.payload.patch.eq(low),
            self.o_subshell.payload.shell.eq(high)]

    def _add_numbers(self, m, before):
        """Numbers, in registers; where a word goes is registered, as its readers are far from each other."""
        given = self.i.payload
        for region, field, elements in (("clusters", "subshells", [self.subshells]),
                                        ("cell_grid", "shape", list(self.cells))):
            for target, (word, is_high) in zip(elements, halves(region, field), strict=True):
                comes = Signal(name=f"{region}_{word}_{is_high}_comes")
                m.d.sync += comes.eq(
                    self.i.valid & (given.region == RegionNumber[region.upper()]) & (given.word == word))
                with m.If(comes):
                    m.d.sync += target.eq(before[word][32:] if is_high else before[word][:32])
