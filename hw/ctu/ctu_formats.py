"""Shapes and payloads of the traversal unit."""

from amaranth.hdl import Shape, signed, unsigned
from amaranth.lib import enum
from amaranth.lib.data import ArrayLayout, StructLayout

from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import BEGIN_BITS, INDEX_BITS, PARAMETER_BITS, POSITION_FRACTION, RECIPROCAL_BITS
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.memory_map import GRID_POSITION_BITS
from hw.formats import Formats

__all__ = ["GRID_GROUP", "CtuFormats", "GridTableKind"]

# Neighbours of a row of grid rays that survival looks at together, at most.
GRID_GROUP = 8
# Bits of what a memory image says: cells along an axis, rows or columns of a shell, the number of a grid ray among
# those of all shells.
GRID_COUNT_BITS = 10
GRID_SIDE_BITS = 12
GRID_NUMBER_BITS = 20
# Bits of the number of a stage, modulo which stages in flight differ.
STAGE_BITS = 4


class GridTableKind(enum.Enum, shape=2):
    """The tables of the grid rays.

    SHELL: `CtuFormats.grid_shell` by the number of the shell. ROW and COLUMN: `CtuFormats.grid_row` and
    `CtuFormats.grid_column`, those of shell 2 first, then those of shell 3, and so on.
    """

    SHELL = 0
    ROW = 1
    COLUMN = 2


class CtuFormats(Formats):
    """The layouts of the traversal unit, and the shared ones.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    grid_pair
        An entry of the tables of grid rays; its numbers have ``FRACTION`` fraction bits in every configuration.
    grid_direction, grid_coordinate
        A component of a grid ray's direction in G; a coordinate in cells.
    grid_index, grid_count
        A cell along an axis; cells along an axis.
    parameter, begin
        Along a grid ray: from its shell's beginning on; at which its shell begins.
    shell, stage
        A shell; a stage (a shell of a subshell) modulo 2^`STAGE_BITS`.
    grid_number
        A grid ray among those of all shells.
    grid_row_address, grid_column_address
        Addresses of the tables of all shells' rows and columns.
    grid_side, grid_group
        Rows or columns of one shell; grid rays of a request.
    position, reach, position_bound
        Among a shell's rays, in units of 2^-``INDEX_FRACTION``; a distance from there; bounds of positions, which are
        sums of them, or less or more than all of them.
    """

    def __init__(self, config: Config):
        super().__init__(config)
        self.grid_pair = ArrayLayout(signed(FRACTION + 2), 2)
        self.grid_direction = signed(RECIPROCAL_BITS + 1)
        self.grid_coordinate = signed(INDEX_BITS + POSITION_FRACTION)
        self.grid_index = signed(INDEX_BITS)
        self.grid_count = unsigned(GRID_COUNT_BITS)
        self.parameter = unsigned(PARAMETER_BITS)
        self.begin = unsigned(BEGIN_BITS)
        self.shell = unsigned(config.ctu.shell_bits)
        self.stage = unsigned(STAGE_BITS)
        self.grid_number = unsigned(GRID_NUMBER_BITS)
        self.grid_row_address = unsigned(config.ctu.grid_row_bits)
        self.grid_column_address = unsigned(config.ctu.grid_column_bits)
        self.grid_side = unsigned(GRID_SIDE_BITS)
        self.grid_group = unsigned(GRID_GROUP.bit_length())
        self.position = signed(1 + GRID_POSITION_BITS)
        self.reach = unsigned(GRID_POSITION_BITS)
        self.position_bound = signed(self.position.width + 2)
        #: A grid ray of one shell: parameters in cells.
        self.grid_ray = StructLayout({"direction": ArrayLayout(self.grid_direction, 3), "begin": self.begin,
                                      "length": self.parameter})
        #: Where a grid ray is: its cell, and the parameters of the next border on each axis and between two of them.
        #: ``up``, ``down``: the ray's direction along each axis, if any. ``inside``: the cell is one of the grid.
        #: ``away``: the ray is outside for good. ``length``: of the shell.
        self.walk = StructLayout({
            "index": ArrayLayout(self.grid_index, 3), "up": 3, "down": 3, "next": ArrayLayout(self.parameter, 3),
            "between": ArrayLayout(self.parameter, 3), "length": self.parameter, "inside": 1, "away": 1})
        #: A listed subshell: the window of a patch, through all shells up to ``shell``; or the ``last`` one, which is
        #: all of the sector to the last shell and has no patch.
        self.subshell = StructLayout({"patch": self.patch, "shell": self.shell, "last": 1})
        #: A subshell with its window, which says nothing of the ``last`` one.
        self.subshell_window = StructLayout({"window": self.window, "shell": self.shell, "last": 1})
        #: Columns of grid rays with positions from ``low`` up to ``end``, and (``wraps``) others up to ``over``.
        self.arcs = StructLayout({"low": self.position_bound, "end": self.position_bound, "wraps": 1,
                                  "over": self.position_bound})
        #: A shell of a subshell: ``rows`` rows of grid rays from ``row`` on, which is the shell's ``row_number``-th
        #: one; the arcs of the subshell's window; and the shell's columns and its first ray. Or none of it (``final``).
        self.grid_stage = StructLayout({
            "stage": self.stage, "shell": self.shell, "row": self.grid_row_address, "row_number": self.grid_side,
            "rows": self.grid_side, "window": self.arcs, "first_column": self.grid_column_address,
            "columns": self.grid_side, "first_ray": self.grid_number, "final": 1})
        #: Neighbours in a row: ``count`` grid rays, the first of them ``ray`` in ``row`` and ``column``. Or none, and
        #: ``last`` or ``final`` as of a `grid_request`.
        self.grid_piece = StructLayout({
            "stage": self.stage, "shell": self.shell, "ray": self.grid_number, "row": self.grid_row_address,
            "column": self.grid_column_address, "count": self.grid_side, "last": 1, "final": 1})
        #: Neighbours in a row that a subshell requests in a shell: ``count`` grid rays, at most `GRID_GROUP`, of the
        #: first the number, and row and column as addresses of the tables; or none, only to say that its stage is over
        #: (``last``) or the frustum (``final``). ``stage`` counts the stages from the frustum's first one on.
        self.grid_request = StructLayout({
            "stage": self.stage, "shell": self.shell, "ray": self.grid_number, "row": self.grid_row_address,
            "column": self.grid_column_address, "count": self.grid_group, "last": 1, "final": 1})
        #: Of a shell: see `golden.engine.memory_map`, ``shells``; ``length`` is end - begin.
        self.grid_shell = StructLayout({
            "begin": self.begin, "length": self.parameter, "threshold": self.threshold, "row_border": self.reach,
            "first_row": self.grid_row_address, "rows": self.grid_side, "first_column": self.grid_column_address,
            "columns": self.grid_side, "first_ray": self.grid_number})
        #: Of a row of grid rays: see `golden.engine.memory_map`, ``grid_rows``.
        self.grid_row = StructLayout({"table": self.grid_pair, "position": self.position, "first_near": self.count,
                                      "near": self.count, "column_reach": self.reach, "column_border": self.reach})
        #: Of a column of grid rays: see `golden.engine.memory_map`, ``grid_columns``.
        self.grid_column = StructLayout({"table": self.grid_pair, "position": self.position})
        records = self.grid_shell, self.grid_row, self.grid_column
        #: An entry of one of the grid rays' tables; ``data`` is the kind's record.
        self.grid_table_write = StructLayout({
            "kind": GridTableKind,
            "index": max(one.width for one in (self.shell, self.grid_row_address, self.grid_column_address)),
            "data": max(Shape.cast(record).width for record in records)})
        #: A frustum for cell traversal: also the matrix of directions to G, the origin in cells of the grid
        #: (``grid_origin``), and how many ``cells`` that has along each axis.
        self.traversal_frustum = StructLayout({
            "frustum": self.frustum, "to_global": ArrayLayout(self.direction_vector, 3),
            "grid_origin": ArrayLayout(self.grid_coordinate, 3), "cells": ArrayLayout(self.grid_count, 3)})
        #: A cell of shell 1, or none, and whether it is the ``last`` one.
        self.near_cell = StructLayout({"cell": self.cell, "is_cell": 1, "last": 1})
        #: A cell that a grid ray of a stage has met, or (``final``) none: the frustum is over.
        self.met_cell = StructLayout({"cell": self.cell, "stage": self.stage, "final": 1})
