"""Shapes and payloads of the machine's streams, from `golden.config`.

Vectors are arrays of their components. A payload is a struct; all blocks that pass it on use the layout from here.
"""

from amaranth.hdl import Shape, signed, unsigned
from amaranth.lib import enum
from amaranth.lib.data import ArrayLayout, StructLayout

from golden.config import Config
from golden.ctu.cell_traversal import BEGIN_BITS, INDEX_BITS, PARAMETER_BITS, PLACE_FRACTION, RECIPROCAL_BITS
from golden.ctu.grid_rays import INDEX_FRACTION
from golden.fixed import Format

__all__ = ["GRID_GROUP", "Formats", "GridTableKind", "TableKind", "shape"]

# Bits of a weight of a ray: those of `golden.frustum.Hemisphere.polar_weights`, and a few for few columns.
WEIGHT_BITS = 42
# Neighbours of a row of grid rays that survival looks at together, at most.
GRID_GROUP = 8


class TableKind(enum.Enum, shape=2):
    """The tables of a frustum, all addressed by column or row of the whole frustum.

    COLUMN: (cos, sin) of each azimuth, or (x, 0) of each column of a screen. ROW: (sin, cos) of each polar angle, or
    (y, 0). SLACK: of each row, see `golden.icu.sbb.SphericalWindows.azimuth_slack`. WEIGHT: of each row's rays.
    """

    COLUMN = 0
    ROW = 1
    SLACK = 2
    WEIGHT = 3


class GridTableKind(enum.Enum, shape=2):
    """The tables of the grid rays.

    SHELL: `Formats.grid_shell` by the number of the shell. ROW and COLUMN: `Formats.grid_row` and
    `Formats.grid_column`, those of shell 2 first, then those of shell 3, and so on.
    """

    SHELL = 0
    ROW = 1
    COLUMN = 2


def shape(format: Format) -> Shape:
    """The Amaranth shape of a fixed-point format."""
    return signed(format.width) if format.is_signed else unsigned(format.width)


class Formats:
    """All layouts of one configuration.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    scene_vertex, vertex, direction, plane
        Three components each: G coordinates, R frame, ray or matrix row, V'_i x V'_j.
    """

    def __init__(self, config: Config):
        numbers, icu = config.numbers, config.icu
        self.config = config
        self.scene = shape(numbers.scene)
        self.direction = shape(numbers.direction)
        self.vector = shape(numbers.vector)
        self.vertex = shape(numbers.vertex)
        self.edge_plane = shape(numbers.edge_plane)
        self.edge_distance = shape(numbers.edge_distance)
        # -1, 0 or 1.
        self.orientation = signed(2)
        self.plane_normal = shape(numbers.plane_normal)
        self.mantissa = shape(numbers.mantissa)
        self.inverse = shape(numbers.inverse)
        self.uv = shape(icu.uv)
        self.aligned_width = 2 * icu.uv_bits + icu.uv_guard + 2
        self.aligned = ArrayLayout(signed(self.aligned_width), 6)
        self.settle = shape(icu.settle)
        # One more than every settle code.
        self.threshold = unsigned(icu.settle_bits + 1)
        self.vertex_exponent = signed(6)
        self.factor_exponent = signed(8)
        self.angle = unsigned(icu.angle_bits)
        # Of the rays of a few hemispheres.
        self.weight_sum = unsigned(WEIGHT_BITS + 2)
        # An angle with a sign, or a quotient from -1 to 1.
        self.coordinate = signed(max(icu.angle_bits + 1, icu.cordic_stages + 2))
        self.patch = unsigned(icu.patch_bits)
        # Of the surface that a patch was split from.
        self.surface = signed(32)
        # An index of a column or a row, and a number of columns or rows.
        self.index = unsigned(icu.side_bits)
        self.count = unsigned(icu.side_bits + 1)
        self.slot = unsigned(icu.slot_bits)
        self.tile = unsigned(icu.ray_bits - 2 * icu.tile_bits)
        # Of a column or a row of tiles.
        self.tile_index = unsigned(icu.side_bits - icu.tile_bits)
        self.ray = unsigned(icu.ray_bits)

        # A component of a grid ray's direction in G; a place in cells; a cell along an axis, and how many there are.
        self.grid_direction = signed(RECIPROCAL_BITS + 1)
        self.place = signed(INDEX_BITS + PLACE_FRACTION)
        self.grid_index = signed(INDEX_BITS)
        self.grid_count = unsigned(10)
        self.cell = unsigned(24)
        # Of a grid ray: from its shell's beginning on, and at which its shell begins.
        self.parameter = unsigned(PARAMETER_BITS)
        self.begin = unsigned(BEGIN_BITS)

        # A shell; a stage (a shell of a subshell) modulo so many; a grid ray's number among those of all shells.
        self.shell = unsigned(config.ctu.shell_bits)
        self.stage = unsigned(4)
        self.grid_number = unsigned(20)
        # Places in the tables of all shells' rows and columns, and how many of them one shell has.
        self.grid_row_place = unsigned(config.ctu.grid_row_bits)
        self.grid_column_place = unsigned(config.ctu.grid_column_bits)
        self.grid_side = unsigned(12)
        self.grid_group = unsigned(GRID_GROUP.bit_length())
        # Among the rays, in units of 2^-INDEX_FRACTION; and how far from there.
        self.position = signed(18 + INDEX_FRACTION)
        self.reach = unsigned(17 + INDEX_FRACTION)
        # What positions are compared with: sums of them, and less and more than all of them.
        self.position_bound = signed(self.position.width + 2)

        self.scene_vector = ArrayLayout(self.scene, 3)
        self.direction_vector = ArrayLayout(self.direction, 3)
        self.vector_vector = ArrayLayout(self.vector, 3)
        self.vertex_vector = ArrayLayout(self.vertex, 3)
        self.edge_plane_vector = ArrayLayout(self.edge_plane, 3)
        self.mantissa_vector = ArrayLayout(self.mantissa, 3)

    @property
    def frustum(self) -> StructLayout:
        """A bundle of rays, and the section of it that is a cluster's own.

        ``section``: first_column <= column < end_column, and likewise rows. ``tiles_across``: tiles in a row of tiles
        of the section. ``longest_direction``: see `golden.frustum.FrustumRecord`, little more than 1; 0 for a screen.
        """
        return StructLayout({
            "is_screen": 1, "origin": self.scene_vector, "matrix": ArrayLayout(self.direction_vector, 3),
            "columns": self.count, "rows": self.count, "column_bits": 5, "row_bits": 5,
            "source": self.surface, "longest_direction": unsigned(self.direction.width - 1),
            "section": self.section, "tiles_across": self.count})

    @property
    def section(self) -> StructLayout:
        """Half-open ranges of columns and rows."""
        return StructLayout(dict.fromkeys(("first_column", "end_column", "first_row", "end_row"), self.count))

    @property
    def direction_pair(self) -> ArrayLayout:
        """An entry of the column table or the row table."""
        return ArrayLayout(self.direction, 2)

    @property
    def table_write(self) -> StructLayout:
        """An entry of one of the frustum's tables; ``data`` is a `direction_pair`, an angle or a weight."""
        return StructLayout({"kind": TableKind, "index": self.index, "data": unsigned(WEIGHT_BITS)})

    @property
    def patch_vertex(self) -> StructLayout:
        """One of the four vertices of a patch; ids are the same in all four."""
        return StructLayout({"patch": self.patch, "surface": self.surface, "vertex": self.scene_vector})

    @property
    def planes(self) -> ArrayLayout:
        """Edge planes in the order of `golden.icu.edge_planes.EDGES`."""
        return ArrayLayout(self.edge_plane_vector, 6)

    @property
    def turns(self) -> StructLayout:
        """The two orientations of a patch, -1, 0 or 1, and whether it is split, see `golden.icu.edge_planes`."""
        return StructLayout({"orientation": ArrayLayout(self.orientation, 2), "split": 1})

    @property
    def signs(self) -> ArrayLayout:
        """-1, 0 or 1 for each component of the planes of the four edges and the first diagonal."""
        return ArrayLayout(ArrayLayout(self.orientation, 3), 5)

    @property
    def factor(self) -> StructLayout:
        """Plane factor m = mantissa 2^exponent."""
        return StructLayout({"mantissa": self.mantissa_vector, "exponent": self.factor_exponent, "dropped": 1})

    @property
    def exponents(self) -> ArrayLayout:
        """Of the four V' of a patch."""
        return ArrayLayout(self.vertex_exponent, 4)

    @property
    def seen(self) -> StructLayout:
        """What windows are made of: the four vertices' coordinates and which of them are in front, and the planes."""
        return StructLayout({"slot": self.slot, "first": ArrayLayout(self.coordinate, 4),
                             "second": ArrayLayout(self.coordinate, 4), "front": 4, "turns": self.turns,
                             "signs": self.signs})

    @property
    def window(self) -> StructLayout:
        """Columns and rows of the frustum; in a hemisphere the columns may go on from the last to the first.

        Counts of 0: no rays.
        """
        return StructLayout({"column_first": self.index, "column_count": self.count,
                             "row_first": self.index, "row_count": self.count})

    @property
    def section_window(self) -> StructLayout:
        """A window's part of the section, counted from the section's first column and row.

        ``column_count`` columns from ``column_first`` on, and (where the window goes round) ``wrapped_count`` columns
        from 0 on, which are others. No rays: ``row_count`` or both of the other counts are 0.
        """
        return StructLayout({"column_first": self.index, "column_count": self.count, "wrapped_count": self.count,
                             "row_first": self.index, "row_count": self.count})

    @property
    def patch_window(self) -> StructLayout:
        """What patch setup gives the ray generator: rays with a settle code below ``threshold`` may improve."""
        return StructLayout({"slot": self.slot, "window": self.section_window, "threshold": self.threshold})

    @property
    def tile_step(self) -> StructLayout:
        """A tile of a window: its number and place, which of its columns and rows lie in the window; ``last`` of it."""
        side = 1 << self.config.icu.tile_bits
        return StructLayout({"slot": self.slot, "threshold": self.threshold, "tile": self.tile,
                             "tile_column": self.tile_index, "tile_row": self.tile_index, "columns": side, "rows": side,
                             "last": 1})

    @property
    def tile_rays(self) -> StructLayout:
        """The rays of a tile that are to be issued."""
        return StructLayout({"slot": self.slot, "tile": self.tile, "tile_column": self.tile_index,
                             "tile_row": self.tile_index, "mask": 1 << 2 * self.config.icu.tile_bits, "last": 1})

    @property
    def issued(self) -> StructLayout:
        """A ray for a patch, its column and row those of the frustum; or none (``is_ray`` 0), only to say ``last``."""
        return StructLayout({"slot": self.slot, "ray": self.ray, "column": self.index, "row": self.index, "is_ray": 1,
                             "last": 1})

    @property
    def slot_record(self) -> StructLayout:
        """What the intersection needs of a patch, read per ray by its slot."""
        return StructLayout({"planes": self.planes, "turns": self.turns, "factor": self.factor,
                             "exponents": self.exponents, "patch": self.patch})

    @property
    def settle_word(self) -> ArrayLayout:
        """Settle codes of a tile: ray (column, row) at (row mod side) side + column mod side."""
        return ArrayLayout(self.settle, 1 << 2 * self.config.icu.tile_bits)

    @property
    def hit(self) -> StructLayout:
        """What a ray hit; ``inverse`` 0: nothing, and then all is 0."""
        return StructLayout({"inverse": self.inverse, "patch": self.patch, "u": self.uv, "v": self.uv})

    @property
    def grid_ray(self) -> StructLayout:
        """A grid ray of one shell: parameters in cells."""
        return StructLayout({"direction": ArrayLayout(self.grid_direction, 3), "begin": self.begin,
                             "length": self.parameter})

    @property
    def walk(self) -> StructLayout:
        """Where a grid ray is: its cell, and the parameters of the next border on each axis and between two of them.

        ``up``, ``down``: which way the ray goes along each axis, if any. ``inside``: the cell is one of the grid.
        ``away``: the ray is outside for good. ``length``: of the shell.
        """
        return StructLayout({"index": ArrayLayout(self.grid_index, 3), "up": 3, "down": 3,
                             "next": ArrayLayout(self.parameter, 3), "between": ArrayLayout(self.parameter, 3),
                             "length": self.parameter, "inside": 1, "away": 1})

    @property
    def subshell(self) -> StructLayout:
        """A listed subshell: the window of a patch, through all shells up to ``shell``; or the ``last`` one, which is
        all of the sector to the last shell and has no patch.
        """
        return StructLayout({"patch": self.patch, "shell": self.shell, "last": 1})

    @property
    def subshell_window(self) -> StructLayout:
        """A subshell with its window, which says nothing of the ``last`` one."""
        return StructLayout({"window": self.window, "shell": self.shell, "last": 1})

    @property
    def arcs(self) -> StructLayout:
        """Columns of grid rays with positions from ``low`` up to ``end``, and (``wraps``) others up to ``over``."""
        return StructLayout({"low": self.position_bound, "end": self.position_bound, "wraps": 1,
                             "over": self.position_bound})

    @property
    def grid_stage(self) -> StructLayout:
        """A shell of a subshell: ``rows`` rows of grid rays from ``row`` on, which is the shell's ``row_number``-th
        one; the arcs of the subshell's window; and the shell's columns and its first ray. Or none of it (``final``).
        """
        return StructLayout({
            "stage": self.stage, "shell": self.shell, "row": self.grid_row_place, "row_number": self.grid_side,
            "rows": self.grid_side, "window": self.arcs, "first_column": self.grid_column_place,
            "columns": self.grid_side, "first_ray": self.grid_number, "final": 1})

    @property
    def grid_piece(self) -> StructLayout:
        """Neighbours in a row: ``count`` grid rays, the first of them ``ray`` in ``row`` and ``column``. Or none, and
        ``last`` or ``final`` as of a `grid_request`.
        """
        return StructLayout({"stage": self.stage, "shell": self.shell, "ray": self.grid_number,
                             "row": self.grid_row_place, "column": self.grid_column_place, "count": self.grid_side,
                             "last": 1, "final": 1})

    @property
    def grid_request(self) -> StructLayout:
        """Neighbours in a row that a subshell asks for in a shell: ``count`` grid rays, at most `GRID_GROUP`, of the
        first the number, and row and column as places in the tables; or none, only to say that its stage is over
        (``last``) or the frustum (``final``).

        ``stage`` counts the stages from the frustum's first one on.
        """
        return StructLayout({"stage": self.stage, "shell": self.shell, "ray": self.grid_number,
                             "row": self.grid_row_place, "column": self.grid_column_place, "count": self.grid_group,
                             "last": 1, "final": 1})

    @property
    def grid_shell(self) -> StructLayout:
        """Of a shell: see `golden.memory_map`, ``shells``; ``length`` is end - begin."""
        return StructLayout({"begin": self.begin, "length": self.parameter, "threshold": self.threshold,
                             "row_border": self.reach, "first_row": self.grid_row_place, "rows": self.grid_side,
                             "first_column": self.grid_column_place, "columns": self.grid_side,
                             "first_ray": self.grid_number})

    @property
    def grid_row(self) -> StructLayout:
        """Of a row of grid rays: see `golden.memory_map`, ``grid_rows``."""
        return StructLayout({"table": self.direction_pair, "position": self.position, "first_near": self.count,
                             "near": self.count, "column_reach": self.reach, "column_border": self.reach})

    @property
    def grid_column(self) -> StructLayout:
        """Of a column of grid rays: see `golden.memory_map`, ``grid_columns``."""
        return StructLayout({"table": self.direction_pair, "position": self.position})

    @property
    def grid_table_write(self) -> StructLayout:
        """An entry of one of the grid rays' tables; ``data`` is the kind's record."""
        return StructLayout({"kind": GridTableKind,
                             "index": max(self.shell.width, self.grid_row_place.width, self.grid_column_place.width),
                             "data": max(Shape.cast(record).width for record in (self.grid_shell, self.grid_row,
                                                                                  self.grid_column))})

    @property
    def traversal_frustum(self) -> StructLayout:
        """A frustum for cell traversal: also the matrix of directions to G, the origin's ``place`` in the grid, and how
        many ``cells`` that has along each axis.
        """
        return StructLayout({"frustum": self.frustum, "to_global": ArrayLayout(self.direction_vector, 3),
                             "place": ArrayLayout(self.place, 3), "cells": ArrayLayout(self.grid_count, 3)})

    @property
    def near_cell(self) -> StructLayout:
        """A cell of shell 1, or none, and whether it is the ``last`` one."""
        return StructLayout({"cell": self.cell, "is_cell": 1, "last": 1})

    @property
    def met_cell(self) -> StructLayout:
        """A cell that a grid ray of a stage has met, or (``final``) none: the frustum is over."""
        return StructLayout({"cell": self.cell, "stage": self.stage, "final": 1})
