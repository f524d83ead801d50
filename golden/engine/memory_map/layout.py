"""The layout of a memory image: header, region table, and the fields of each region's records."""

from dataclasses import dataclass

import numpy as np

__all__ = ["ALIGNMENT", "ENTRY", "EVERY_CLUSTER", "FRUSTUM_FIELDS", "GRID_POSITION_BITS", "GRID_RAY_BITS",
           "GRID_SHAPE_BITS", "GRID_SIDE_BITS", "HEADER", "MAGIC", "NONE", "REGIONS", "VERSION", "WEIGHT_BITS", "Field",
           "Region"]

MAGIC = int.from_bytes(b"RADE", "little")
VERSION = 3
# Every region begins at a multiple of this, so that no record of up to 64 bytes crosses a 4 KiB border.
ALIGNMENT = 64
# An empty entry of a table of patch or cluster numbers; a patch of which each cluster has a copy.
NONE, EVERY_CLUSTER = -1, -2
# Bits of: the number of cells along an axis; the number of rows, or of columns, of one shell's grid rays; a grid ray's
# number among those of all shells; the magnitude of its position among the rays, and of a distance from there.
GRID_SHAPE_BITS = 10
GRID_SIDE_BITS = 12
GRID_RAY_BITS = 20
GRID_POSITION_BITS = 25
# Of the weight of a ray; those of a hemisphere are 2^40 together at most.
WEIGHT_BITS = 42


@dataclass(frozen=True)
class Field:
    """A field of a record: its numpy type (without byte order), its meaning, and its number of elements."""

    name: str
    type: str
    about: str
    count: int = 1


@dataclass(frozen=True)
class Region:
    """An array of records.

    Parameters
    ----------
    name, about
        Name and meaning of the region.
    life
        How long it stays: ``scene``, ``phase`` or ``job``.
    record
        Meaning of one record.
    fields
        Fields in the order of their bytes, without gaps.
    """

    name: str
    life: str
    record: str
    about: str
    fields: tuple[Field, ...]

    @property
    def dtype(self) -> np.dtype:
        """Little-endian numpy type of one record."""
        return np.dtype([(field.name, "<" + field.type, *([(field.count,)] if field.count > 1 else []))
                         for field in self.fields])


HEADER = Region("header", "scene", "image", "Magic number, version and size.", (
    Field("magic", "u4", f"{MAGIC:#x}"),
    Field("version", "u4", f"{VERSION}"),
    Field("size", "u8", "bytes of the whole image"),
))
ENTRY = Region("region table", "scene", "region, in the order of the sections below", "Follows the header.", (
    Field("offset", "u8", "first byte, from the start of the image; a multiple of 64"),
    Field("count", "u8", "records"),
))
# The bundle of rays in a frustum's record, without what only the host needs. Matrix entries are signed 1.16.
FRUSTUM_FIELDS = (
    Field("bundle", "u4", "the kind of the rays, 0: hemisphere, 1: screen, 2: shadow frustum"),
    Field("source", "i4", "surface that the rays leave, -1: none"),
    Field("columns", "u4", "azimuths or pixels across"),
    Field("rows", "u4", "polar angles or pixels down"),
    Field("column_bits", "u4", "binary logarithm of the full grid's columns; the frustum's are the middle ones"),
    Field("row_bits", "u4", "the same for the rows"),
    Field("origin", "u4", "G coordinates", 3),
    Field("matrix", "i4", "G to R, row by row", 9),
    Field("to_global", "i4", "directions of grid rays to G, row by row", 9),
    Field("z_scale", "u4", "R coordinate of depth 1, unsigned 1.16"),
    Field("grid_origin", "i4", "origin from the grid's lower corner, units of 2^-16 cells", 3),
    Field("longest_direction", "u4", "upper bound of the directions' lengths, unsigned 1.16; screen: 0"),
)
# The image of a phase: what all its frusta share.
REGIONS = (
    Region("cell_grid", "scene", "scene", "The grid of cells, in scene (G) coordinates of 2^-24.", (
        Field("lower", "i4", "lower corner", 3),
        Field("cell", "u4", "side of a cell"),
        Field("shape", "u4", f"cells along x, y, z, each below {1 << GRID_SHAPE_BITS}; cell (x, y, z) has the number "
              "(x shape_y + y) shape_z + z", 3),
        Field("reserved", "u4", "0"),
    )),
    Region("cells", "scene", "cell", "The cell address table.", (
        Field("pointer", "u4", "first entry in patch_lists"),
        Field("count", "u4", "entries"),
    )),
    Region("patch_lists", "scene", "entry", "The patch address table: the patch lists of all cells.", (
        Field("patch", "u4", "patch id"),
    )),
    Region("patches", "scene", "patch id", "Patch geometry: five beats of 72 bits, 48 of 64 bytes. The low 64 bits of "
           "beat 0 are id and surface, those of beats 1 to 4 (one vertex each: x in bits 0-23, y in 24-47, z in 48-71) "
           "are vertex; byte k of top is bits 64-71 of beat k.", (
        Field("id", "u4", "patch id"),
        Field("surface", "i4", "the surface that the patch was split from; rays that leave this surface never hit it"),
        Field("top", "u1", "the highest byte of each beat, that of beat 0 is 0", 5),
        Field("kind", "u1", "0: a quad"),
        Field("padding", "u1", "0", 2),
        Field("vertex", "u8", "low 64 bits of each vertex, which are not all 0; a triangle repeats its last one", 4),
        Field("reserved", "u8", "0", 2),
    )),
    Region("residence", "phase", "patch id", "The node that holds a copy of the patch.", (
        Field("cluster", "i4", f"{NONE}: main memory only, {EVERY_CLUSTER}: each cluster has a copy"),
        Field("address", "i4", f"local address there, {NONE}: none"),
    )),
    Region("clusters", "phase", "cluster, then patch node", "Preloaded tables. Residents that every cluster holds are "
           "those of cluster 0; the others have none then.", (
        Field("first_subshell", "u4", "first record in subshells"),
        Field("subshells", "u4", "records"),
        Field("first_resident", "u4", "first record in residents"),
        Field("residents", "u4", "records"),
        Field("processor", "u4", "the processor that serves as this cluster"),
        Field("reserved", "u4", "0", 3),
    )),
    Region("subshells", "phase", "subshell", "Subshell lists, cluster by cluster; the last subshell, the whole "
           "sector to the last shell, is not listed.", (
        Field("patch", "u4", "the patch whose window the subshell covers"),
        Field("shell", "u4", "grid rays end with this shell"),
    )),
    Region("residents", "phase", "local address", "Resident sets, cluster by cluster.", (
        Field("patch", "u4", "patch id"),
    )),
    Region("columns", "phase", "column of rays", "Ray table, signed 1.16.", (
        Field("table", "i4", "cos and sin of the azimuth; screen: x and 0", 2),
    )),
    Region("rows", "phase", "row of rays", "Ray table, signed 1.16, and the weights whose sums are formed per patch.", (
        Field("table", "i4", "sin and cos of the polar angle; screen: y and 0", 2),
        Field("weight", "u8", f"form factor of one ray in units of 2^-W, below 2^{WEIGHT_BITS}; screen: 0"),
        Field("slack", "u4", "bound of the error of the table's azimuths, in units of an angle; screen: 0"),
        Field("reserved", "u4", "0"),
    )),
    Region("shells", "phase", "shell, from shell 2", "Grid rays of each shell: every row with every column. Their "
           f"positions, reaches and borders are below 2^{GRID_POSITION_BITS} in magnitude; the host checks it.", (
        Field("begin", "u4", "parameter at which the shell begins, units of 2^-16 cells"),
        Field("end", "u4", "parameter at which the shell ends, units of 2^-16 cells"),
        Field("threshold", "u4", "a ray may still change while its settle code is below this"),
        Field("row_border", "u4", "margin of a sector's grid rays beside its rows, 1/256 row"),
        Field("first_row", "u4", "first record in grid_rows"),
        Field("rows", "u4", f"records, below {1 << GRID_SIDE_BITS}"),
        Field("first_column", "u4", "first record in grid_columns"),
        Field("columns", "u4", f"records, below {1 << GRID_SIDE_BITS}"),
        Field("first_ray", "u4", f"grid rays of the earlier shells, from shell 2; at most {1 << GRID_RAY_BITS} in all"),
        Field("reserved", "u4", "0"),
    )),
    Region("grid_rows", "phase", "row of grid rays", "Directions, signed 1.16, and the rays near them.", (
        Field("table", "i4", "sin and cos of the polar angle; screen: scaled slope, and 0", 2),
        Field("position", "i4", "position among the rows of rays, 1/256 row"),
        Field("first_near", "u4", "first row of rays near this one"),
        Field("near", "u4", "rows of rays near this one"),
        Field("column_reach", "u4", "a column of rays is near if its middle is at most this far away, 1/256 column"),
        Field("column_border", "u4", "margin of a sector's grid rays beside its columns, 1/256 column"),
        Field("reserved", "u4", "0"),
    )),
    Region("grid_columns", "phase", "column of grid rays", "Directions, signed 1.16.", (
        Field("table", "i4", "cos and sin of the azimuth; screen: scaled slope, and 0", 2),
        Field("position", "i4", "position among the columns of rays, 1/256 column"),
        Field("reserved", "u4", "0"),
    )),
)
