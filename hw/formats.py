"""Shapes and payloads that several units share, from `golden.engine.config`.

Vectors are arrays of their components. A payload is a struct; all blocks that pass it on use the layout from here, from
`hw.icu.icu_formats` or from `hw.ctu.ctu_formats`.
"""

from amaranth.hdl import Shape, signed, unsigned
from amaranth.lib.data import ArrayLayout, StructLayout

from golden.engine.config import Config
from golden.engine.lib.fixed import Format

__all__ = ["VERTICES", "Formats", "shape"]

# Of a patch.
VERTICES = 4
# Bits of the number of a surface and of the number of a cell in a memory image.
SURFACE_BITS, CELL_BITS = 32, 24


def shape(format: Format) -> Shape:
    """The Amaranth shape of a fixed-point format."""
    return signed(format.width) if format.is_signed else unsigned(format.width)


class Formats:
    """The layouts of one configuration that several units share.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    scene, direction, inverse
        A G coordinate; a component of a ray or of a matrix row; a stored inverse distance.
    scene_vector, direction_vector
        Three components each.
    patch, surface
        Id of a patch, and the number of the surface that it was split from.
    index, count
        Of a column or a row of a frustum; a number of columns or rows.
    settle, threshold
        A settle code; a bound that may be above all codes.
    cell, tile
        The number of a cell of the scene; a tile of the settle map.
    """

    def __init__(self, config: Config):
        numbers, icu = config.numbers, config.icu
        self.scene = shape(numbers.scene)
        self.direction = shape(numbers.direction)
        self.inverse = shape(numbers.inverse)
        self.scene_vector = ArrayLayout(self.scene, 3)
        self.direction_vector = ArrayLayout(self.direction, 3)
        self.patch = unsigned(icu.patch_bits)
        self.surface = signed(SURFACE_BITS)
        self.index = unsigned(icu.side_bits)
        self.count = unsigned(icu.side_bits + 1)
        self.settle = shape(icu.settle)
        self.threshold = unsigned(icu.settle_bits + 1)
        self.cell = unsigned(CELL_BITS)
        self.tile = unsigned(icu.ray_bits - 2 * icu.tile_bits)
        #: Half-open ranges of columns and rows.
        self.section = StructLayout(dict.fromkeys(("first_column", "end_column", "first_row", "end_row"), self.count))
        side = range(icu.side_bits + 1)
        shadow = {"is_shadow": 1} if icu.shadow_bits else {}
        #: A bundle of rays, and the section of it that is a cluster's own. ``section``: first_column <= column <
        #: end_column, and likewise rows. ``tiles_across``: tiles in a row of tiles of the section.
        #: ``longest_direction``: see `golden.engine.frustum.FrustumRecord`, little more than 1; 0 for a screen. A
        #: shadow frustum is a screen too.
        self.frustum = StructLayout({
            "is_screen": 1, **shadow, "origin": self.scene_vector, "matrix": ArrayLayout(self.direction_vector, 3),
            "columns": self.count, "rows": self.count, "column_bits": side, "row_bits": side, "source": self.surface,
            "longest_direction": unsigned(self.direction.width - 1), "section": self.section,
            "tiles_across": self.count})
        #: An entry of the column table or the row table.
        self.direction_pair = ArrayLayout(self.direction, 2)
        #: One of the four vertices of a patch; ids are the same in all four.
        self.patch_vertex = StructLayout({"patch": self.patch, "surface": self.surface, "vertex": self.scene_vector})
        #: Columns and rows of the frustum; in a hemisphere the columns may go on from the last to the first. Counts of
        #: 0: no rays.
        self.window = StructLayout({"column_first": self.index, "column_count": self.count, "row_first": self.index,
                                    "row_count": self.count})
        #: Settle codes of a tile: ray (column, row) at (row mod side) side + column mod side.
        self.settle_word = ArrayLayout(self.settle, 1 << 2 * icu.tile_bits)
