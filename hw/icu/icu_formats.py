"""Shapes and payloads of the intersection unit."""

from amaranth.hdl import Shape, signed, unsigned
from amaranth.lib import enum
from amaranth.lib.data import ArrayLayout, StructLayout

from golden.engine.config import Config
from hw.formats import Formats, shape
from hw.icu.icu_tables import WEIGHT_BITS

__all__ = ["LIST_WORD_BITS", "PHASES", "WEIGHT_BITS", "IcuFormats", "TableKind"]

# A patch has four vertices, and four edges: setup works on one of them per phase.
PHASES = 4
# Rays of a list whose bits are a word.
LIST_WORD_BITS = 64


class TableKind(enum.Enum, shape=2):
    """The tables of a frustum, all addressed by column or row of the whole frustum.

    COLUMN: (cos, sin) of each azimuth, or (x, 0) of each column of a screen. ROW: (sin, cos) of each polar angle, or
    (y, 0). SLACK: of each row, see `golden.engine.icu.sbb.SphericalWindows.azimuth_slack`. WEIGHT: of each row's rays.
    """

    COLUMN = 0
    ROW = 1
    SLACK = 2
    WEIGHT = 3


class IcuFormats(Formats):
    """The layouts of the intersection unit, and the shared ones.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    vector, vertex, edge_plane, plane_normal, mantissa
        Components: of a vertex in the R frame, of V', of V'_i x V'_j, of N, of the plane factor m.
    vector_vector, vertex_vector, edge_plane_vector, mantissa_vector
        Three components each.
    orientation
        -1, 0 or 1.
    edge_distance, aligned_width, aligned
        n_ij . d; the same of all edge planes with a common exponent.
    vertex_exponent, factor_exponent
        Of V' and of m.
    uv, angle, coordinate
        A step of the patch's lattice; an angle; a signed angle or a quotient from -1 to 1.
    slot, ray
        Of a patch in flight; of a ray in the ray memory.
    tile_index
        A column or row of tiles.
    """

    def __init__(self, config: Config):
        super().__init__(config)
        numbers, icu = config.numbers, config.icu
        self.vector = shape(numbers.vector)
        self.vertex = shape(numbers.vertex)
        self.edge_plane = shape(numbers.edge_plane)
        self.edge_distance = shape(numbers.edge_distance)
        self.orientation = signed(2)
        self.plane_normal = shape(numbers.plane_normal)
        self.mantissa = shape(numbers.mantissa)
        self.uv = shape(icu.uv)
        self.aligned_width = 2 * icu.uv_bits + icu.uv_guard + 2
        self.aligned = ArrayLayout(signed(self.aligned_width), 6)
        # From the vertex (0, 0, 0) to one whose largest magnitude has all bits.
        self.vertex_exponent = Shape.cast(range(-numbers.vertex_bits, numbers.vector.width - numbers.vertex_bits))
        # That of m = N / V is within this range for every configuration that is allowed.
        self.factor_exponent = signed(8)
        self.angle = unsigned(icu.angle_bits)
        self.coordinate = signed(max(icu.angle_bits + 1, icu.cordic_stages + 2))
        self.slot = unsigned(icu.slot_bits)
        self.tile_index = unsigned(icu.side_bits - icu.tile_bits)
        self.ray = unsigned(icu.ray_bits)
        self.vector_vector = ArrayLayout(self.vector, 3)
        self.vertex_vector = ArrayLayout(self.vertex, 3)
        self.edge_plane_vector = ArrayLayout(self.edge_plane, 3)
        self.mantissa_vector = ArrayLayout(self.mantissa, 3)
        #: An entry of one of the frustum's tables; ``data`` is a `direction_pair`, an angle or a weight.
        self.table_write = StructLayout({"kind": TableKind, "index": self.index, "data": unsigned(WEIGHT_BITS)})
        #: Edge planes in the order of `golden.engine.icu.edge_planes.EDGES`.
        self.planes = ArrayLayout(self.edge_plane_vector, 6)
        #: The two orientations of a patch, -1, 0 or 1, and whether it is split, see `golden.engine.icu.edge_planes`.
        self.winding = StructLayout({"orientation": ArrayLayout(self.orientation, 2), "split": 1})
        #: -1, 0 or 1 for each component of the planes of the four edges and the first diagonal.
        self.signs = ArrayLayout(ArrayLayout(self.orientation, 3), 5)
        #: Plane factor m = mantissa 2^exponent.
        self.factor = StructLayout({"mantissa": self.mantissa_vector, "exponent": self.factor_exponent, "dropped": 1})
        #: Of the four V' of a patch.
        self.exponents = ArrayLayout(self.vertex_exponent, 4)
        #: What windows are made of: the four vertices' coordinates and which of them are in front, and the planes.
        self.seen = StructLayout({
            "slot": self.slot, "first": ArrayLayout(self.coordinate, 4), "second": ArrayLayout(self.coordinate, 4),
            "front": 4, "winding": self.winding, "signs": self.signs})
        #: A window's part of the section, counted from the section's first column and row. ``column_count`` columns
        #: from ``column_first`` on, and (where the window wraps around) ``wrapped_count`` columns from 0 on, which are
        #: others. No rays: ``row_count`` or both of the other counts are 0.
        self.section_window = StructLayout({
            "column_first": self.index, "column_count": self.count, "wrapped_count": self.count,
            "row_first": self.index, "row_count": self.count})
        #: What patch setup gives the ray generator: rays with a settle code below ``threshold`` may improve.
        self.patch_window = StructLayout({"slot": self.slot, "window": self.section_window,
                                          "threshold": self.threshold})
        side = 1 << icu.tile_bits
        #: A tile of a window: its number, column and row, and which of its columns and rows lie in the window; ``last``
        #: of the window or not.
        self.tile_step = StructLayout({
            "slot": self.slot, "threshold": self.threshold, "tile": self.tile, "tile_column": self.tile_index,
            "tile_row": self.tile_index, "columns": side, "rows": side, "last": 1})
        #: The rays of a tile that are to be issued.
        self.tile_rays = StructLayout({
            "slot": self.slot, "tile": self.tile, "tile_column": self.tile_index, "tile_row": self.tile_index,
            "mask": 1 << 2 * icu.tile_bits, "last": 1})
        #: A ray for a patch, its column and row those of the frustum; or none (``is_ray`` 0), only to say ``last``.
        self.issued = StructLayout({"slot": self.slot, "ray": self.ray, "column": self.index, "row": self.index,
                                    "is_ray": 1, "last": 1})
        exponents = {"exponents": self.exponents} if icu.uv_bits else {}
        #: What the intersection needs of a patch, read per ray by its slot: ``exponents`` for (u, v) alone.
        self.slot_record = StructLayout({"planes": self.planes, "winding": self.winding, "factor": self.factor,
                                         **exponents, "patch": self.patch})
        #: The sum of the weights of a section's rays that hit a patch, the ``last`` one or not; ``overflow``: it was
        #: larger. Without ``is_sum`` no patch has one, and the other fields but ``last`` have no meaning.
        self.section_sum = StructLayout({"patch": self.patch, "sum": unsigned(WEIGHT_BITS), "overflow": 1, "is_sum": 1,
                                         "last": 1})
        #: A slope of a listed ray, counted from the border of the grid.
        self.place = unsigned(numbers.direction_fraction + 1)
        #: A ray of a shadow frustum's list: its slopes and its end, see `golden.engine.frustum.ray_list`.
        self.ray_entry = StructLayout({"x": self.place, "y": self.place, "end": self.inverse})
        #: The same with its place in the ray memory; one that is not ``is_ray`` is none of the section's.
        self.listed_ray = StructLayout({"ray": self.ray, **dict(self.ray_entry.members), "is_ray": 1, "last": 1})
        #: What a ray hit; ``inverse`` 0: nothing, and then all is 0.
        self.hit = StructLayout({"inverse": self.inverse, "patch": self.patch, "u": self.uv, "v": self.uv})
        words = {"is_word": 1, "word": LIST_WORD_BITS} if icu.shadow_bits else {}
        #: A ray of a section that is read out, and its hit; or of a list a ``word`` of bits, in place of a hit.
        self.read_ray = StructLayout({"column": self.index, "row": self.index, "hit": self.hit, "last": 1, **words})
