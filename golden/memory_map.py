"""The memory map: every byte that passes between host and machine.

An image is a header, a table of regions, and the regions, each an array of equal records. `REGIONS` is the layout;
`to_bytes` and `from_bytes` follow it, and the tables of docs/memory-map.md are `layout_tables`. Fields are as wide as
the largest configuration needs, so one layout serves all.

Integers are little-endian; signed ones are two's complement.
"""

from dataclasses import dataclass

import numpy as np

from golden.cast.fixed_hits import FixedHits
from golden.config import Config, Numbers
from golden.ctu.sector import Sector
from golden.ctu.unit import CellTraversalUnit
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.icu.sbb import SphericalWindows
from golden.memsys.cell_table import CellTable
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.phase import Schedule

__all__ = ["ALIGNMENT", "MAGIC", "REGIONS", "VERSION", "Field", "MemoryImage", "Region", "from_bytes", "layout_tables",
           "machine_image", "pack_beats", "unpack_beats"]

MAGIC = int.from_bytes(b"RADE", "little")
VERSION = 2
# Every region begins at a multiple of this, so that no record of up to 64 bytes crosses a 4 KiB border.
ALIGNMENT = 64
# What an empty place in a table of patch or cluster numbers holds.
NONE = -1
BEATS = 5
COORDINATE_BITS = 24


@dataclass(frozen=True)
class Field:
    """A field of a record: numpy type (little-endian), number of elements, meaning."""

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
        What it is.
    life
        How long it stays: ``scene``, ``phase``, ``frustum``, or ``result`` (written by the machine).
    record
        What one record stands for.
    fields
        In the order of their bytes, without gaps.
    """

    name: str
    life: str
    record: str
    about: str
    fields: tuple[Field, ...]

    @property
    def dtype(self) -> np.dtype:
        """Of one record."""
        return np.dtype([(field.name, "<" + field.type, *([(field.count,)] if field.count > 1 else []))
                         for field in self.fields])


HEADER = Region("header", "scene", "image", "Where everything is.", (
    Field("magic", "u4", f"{MAGIC:#x}"),
    Field("version", "u4", f"{VERSION}"),
    Field("size", "u8", "bytes of the whole image"),
))
ENTRY = Region("region table", "scene", "region, in the order of the sections below", "Follows the header.", (
    Field("offset", "u8", "first byte, from the start of the image; a multiple of 64"),
    Field("count", "u8", "records"),
))
REGIONS = (
    Region("cell_grid", "scene", "scene", "The grid of cells, in scene (G) coordinates of 2^-24.", (
        Field("lower", "i4", "lower corner", 3),
        Field("cell", "u4", "side of a cell"),
        Field("shape", "u4", "cells along x, y, z; cell (x, y, z) has the number (x shape_y + y) shape_z + z", 3),
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
        Field("surface", "i4", "what the patch was split from; rays that leave this surface never hit it"),
        Field("top", "u1", "the highest byte of each beat, that of beat 0 is 0; then 3 bytes 0", 8),
        Field("vertex", "u8", "low 64 bits of each vertex; a triangle repeats its last one", 4),
        Field("reserved", "u8", "0", 2),
    )),
    Region("residence", "phase", "patch id", "Where a copy of the patch is held.", (
        Field("cluster", "i4", "-1: main memory only"),
        Field("address", "i4", "local address there, -1: none"),
    )),
    Region("clusters", "phase", "cluster", "Section and sector, and what is preloaded. Rays of the section: "
           "first_column <= column < end_column, and likewise rows.", (
        Field("first_column", "u4", "section"),
        Field("end_column", "u4", "section"),
        Field("first_row", "u4", "section"),
        Field("end_row", "u4", "section"),
        Field("processor", "u4", "the processor that is this cluster"),
        Field("first_subshell", "u4", "in subshells"),
        Field("subshells", "u4", "how many"),
        Field("first_resident", "u4", "in residents"),
        Field("residents", "u4", "how many"),
        Field("reserved", "u4", "0", 7),
    )),
    Region("subshells", "phase", "subshell", "Subshell lists, cluster by cluster; the last subshell, all of the "
           "sector to the last shell, is not listed.", (
        Field("patch", "u4", "the patch whose window it is"),
        Field("shell", "u4", "grid rays go on to the end of this shell"),
    )),
    Region("residents", "phase", "local address", "Resident sets, cluster by cluster.", (
        Field("patch", "u4", "patch id"),
    )),
    Region("frustum", "frustum", "frustum", "The bundle of rays. Matrix entries are signed 1.16.", (
        Field("is_screen", "u4", "1: screen, 0: hemisphere"),
        Field("source", "i4", "surface that the rays leave, -1: none"),
        Field("columns", "u4", "azimuths or pixels across"),
        Field("rows", "u4", "polar angles or pixels down"),
        Field("column_bits", "u4", "logarithm of the grid of which the columns are the middle"),
        Field("row_bits", "u4", "likewise of the rows"),
        Field("origin", "u4", "G coordinates", 3),
        Field("matrix", "i4", "G to R, row by row", 9),
        Field("to_global", "i4", "directions of grid rays to G, row by row", 9),
        Field("z_scale", "u4", "R coordinate of depth 1, unsigned 1.16"),
        Field("half_angles", "f8", "slopes of a screen's x = 1 and y = 1, for the host; 1 in a hemisphere", 2),
        Field("place", "i4", "origin from the grid's lower corner, units of 2^-16 cells", 3),
        Field("longest_direction", "u4", "upper bound of the directions' lengths, unsigned 1.16; screen: 0"),
    )),
    Region("columns", "frustum", "column of rays", "Ray table, signed 1.16.", (
        Field("table", "i4", "cos and sin of the azimuth; screen: x and 0", 2),
    )),
    Region("rows", "frustum", "row of rays", "Ray table, signed 1.16, and the weights that the collector adds.", (
        Field("table", "i4", "sin and cos of the polar angle; screen: y and 0", 2),
        Field("weight", "u8", "form factor of one ray in units of 2^-W; screen: 0"),
        Field("slack", "u4", "how far the table's azimuths may be off, in units of an angle; screen: 0"),
        Field("reserved", "u4", "0"),
    )),
    Region("near_cells", "frustum", "cell", "The cells of shell 1, which are opened without grid rays.", (
        Field("cell", "u4", "cell number, ascending"),
    )),
    Region("shells", "frustum", "shell, from shell 2", "Grid rays of each shell: every row with every column.", (
        Field("begin", "u4", "parameter at which the shell begins, units of 2^-16 cells"),
        Field("end", "u4", "and ends"),
        Field("threshold", "u4", "a ray may still change while its settle code is below this"),
        Field("row_border", "u4", "how far past a sector's rows its grid rays go, 1/256 row"),
        Field("first_row", "u4", "in grid_rows"),
        Field("rows", "u4", "how many"),
        Field("first_column", "u4", "in grid_columns"),
        Field("columns", "u4", "how many"),
        Field("first_ray", "u4", "grid rays of the shells before it, those of shell 2 on"),
        Field("reserved", "u4", "0"),
    )),
    Region("grid_rows", "frustum", "row of grid rays", "Directions, signed 1.16, and the rays near them.", (
        Field("table", "i4", "sin and cos of the polar angle; screen: slope over the stretch, and 0", 2),
        Field("position", "i4", "among the rows of rays, 1/256 row"),
        Field("first_near", "u4", "first row of rays near this one"),
        Field("near", "u4", "how many rows"),
        Field("column_reach", "u4", "columns of rays whose middle is this near are near, 1/256 column"),
        Field("column_border", "u4", "how far past a sector's columns its grid rays go, 1/256 column"),
        Field("reserved", "u4", "0"),
    )),
    Region("grid_columns", "frustum", "column of grid rays", "Directions, signed 1.16.", (
        Field("table", "i4", "cos and sin of the azimuth; screen: slope over the stretch, and 0", 2),
        Field("position", "i4", "among the columns of rays, 1/256 column"),
        Field("reserved", "u4", "0"),
    )),
    Region("hits", "result", "ray (row x columns + column)", "What each ray hits.", (
        Field("inverse", "u4", "stored inverse distance, 0: no hit"),
        Field("patch", "i4", "patch id, -1: no hit"),
        Field("u", "u2", "where on the patch"),
        Field("v", "u2", "where on the patch"),
        Field("reserved", "u4", "0"),
    )),
    Region("sums", "result", "patch id, and one more for the rays that hit nothing",
           "The collector's sums.", (
        Field("sum", "u8", "weights of the rays that hit it, in units of 2^-W"),
    )),
)


@dataclass(frozen=True, eq=False)
class MemoryImage:
    """The regions of an image as arrays of records, by name, in the order of `REGIONS`."""

    regions: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.regions[name]

    def to_bytes(self) -> bytes:
        """The image: the same regions give the same bytes."""
        entries = np.zeros(len(REGIONS), dtype=ENTRY.dtype)
        end = HEADER.dtype.itemsize + entries.nbytes
        for entry, region in zip(entries, REGIONS, strict=True):
            entry["offset"] = _aligned(end)
            entry["count"] = len(self[region.name])
            end = int(entry["offset"]) + self[region.name].nbytes
        image = bytearray(_aligned(end))
        header = np.array([(MAGIC, VERSION, len(image))], dtype=HEADER.dtype)
        head = header.tobytes() + entries.tobytes()
        image[:len(head)] = head
        for entry, region in zip(entries, REGIONS, strict=True):
            data = self[region.name].tobytes()
            image[int(entry["offset"]):int(entry["offset"]) + len(data)] = data
        return bytes(image)

    @property
    def offsets(self) -> dict[str, int]:
        """First byte of each region."""
        image = np.frombuffer(self.to_bytes(), dtype=ENTRY.dtype, count=len(REGIONS), offset=HEADER.dtype.itemsize)
        return {region.name: int(entry["offset"]) for region, entry in zip(REGIONS, image, strict=True)}

    def vertices(self) -> np.ndarray:
        """N x 4 x 3 int64, G coordinates."""
        return unpack_beats(self["patches"]["vertex"], self["patches"]["top"][:, 1:BEATS])

    def sections(self) -> tuple[Sector, ...]:
        """Section and sector of each cluster."""
        names = "first_column", "end_column", "first_row", "end_row"
        return tuple(Sector(*(int(cluster[name]) for name in names)) for cluster in self["clusters"])

    def residents(self, cluster: int) -> np.ndarray:
        """Patch ids of a cluster's resident set, by local address."""
        return _listed(self["residents"]["patch"], self["clusters"][cluster], "first_resident", "residents")

    def subshells(self, cluster: int) -> np.ndarray:
        """S x 2 int64: patch and shell of each listed subshell of a cluster."""
        listed = _listed(self["subshells"], self["clusters"][cluster], "first_subshell", "subshells")
        return np.stack([listed["patch"], listed["shell"]], axis=1).astype(np.int64)

    def frustum(self, numbers: Numbers) -> FrustumRecord:
        """The frustum record."""
        (one,) = self["frustum"]
        used = 1 if one["is_screen"] else 2
        wide = np.int64
        return FrustumRecord(
            is_screen=bool(one["is_screen"]), numbers=numbers, origin=one["origin"].astype(wide),
            matrix=one["matrix"].reshape(3, 3).astype(wide), to_global=one["to_global"].reshape(3, 3).astype(wide),
            z_scale=int(one["z_scale"]), half_angles=tuple(float(angle) for angle in one["half_angles"]),
            columns=int(one["columns"]), rows=int(one["rows"]), column_bits=int(one["column_bits"]),
            row_bits=int(one["row_bits"]), column_table=self["columns"]["table"][:, :used].astype(wide),
            row_table=self["rows"]["table"][:, :used].astype(wide), source=int(one["source"]))

    def hits(self) -> FixedHits:
        """What the machine, or `with_results`, has written."""
        return FixedHits(**{name: self["hits"][name].astype(np.int64) for name in ("inverse", "patch", "u", "v")})

    def with_results(self, hits: FixedHits) -> "MemoryImage":
        """The image as the machine leaves it: hits, and the sums that follow from them."""
        written, sums = self["hits"].copy(), self["sums"].copy()
        for name in "inverse", "patch", "u", "v":
            written[name] = getattr(hits, name)
        weight = np.repeat(self["rows"]["weight"], len(self["columns"]))
        sums["sum"] = 0
        np.add.at(sums["sum"], np.where(hits.patch >= 0, hits.patch, len(sums) - 1), weight)
        return MemoryImage({**self.regions, "hits": written, "sums": sums})


def machine_image(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, plan: Schedule, *,
                  weights: np.ndarray | None = None) -> MemoryImage:
    """Everything that the machine reads for one frustum of a phase, and room for what it writes.

    Parameters
    ----------
    record
        The frustum; not necessarily the one that the phase was scheduled for, but with as many rays.
    geometry, table
        The scene.
    plan
        The phase.
    weights
        ``rows`` int64, form factor of one ray of each row (`Hemisphere.polar_weights`); 0 if not given.

    Errors
    ------
    InputError
        The schedule is for another number of rays.
    """
    if (record.columns, record.rows) != (plan.partition.columns, plan.partition.rows):
        raise InputError(f"memory image: Frustum must have the schedule's {plan.partition.columns} x "
                         f"{plan.partition.rows} rays, not {record.columns} x {record.rows}")
    regions = {**_scene_regions(geometry, table), **_phase_regions(plan, len(geometry)),
               **_frustum_regions(record, table, config, weights), **_shell_regions(record, table, config),
               "hits": _records("hits", len(record), patch=NONE), "sums": _records("sums", len(geometry) + 1)}
    return MemoryImage({region.name: regions[region.name] for region in REGIONS})


def from_bytes(data: bytes) -> MemoryImage:
    """The image in ``data``.

    Errors
    ------
    InputError
        It is no image, of another version, cut off, a region lies outside it, or a table points outside another.
    """
    if len(data) < HEADER.dtype.itemsize + len(REGIONS) * ENTRY.dtype.itemsize:
        raise InputError(f"memory image: {len(data)} bytes are too few for a header")
    (header,) = np.frombuffer(data, dtype=HEADER.dtype, count=1)
    for name, expected in ("magic", MAGIC), ("version", VERSION), ("size", len(data)):
        if header[name] != expected:
            raise InputError(f"memory image: {name.capitalize()} must be {expected}, not {header[name]}")
    entries = np.frombuffer(data, dtype=ENTRY.dtype, count=len(REGIONS), offset=HEADER.dtype.itemsize)
    regions = {}
    for entry, region in zip(entries, REGIONS, strict=True):
        offset, count = int(entry["offset"]), int(entry["count"])
        if offset % ALIGNMENT or offset + count * region.dtype.itemsize > len(data):
            raise InputError(f"memory image: region {region.name}, {count} records at {offset}, lies outside the image")
        regions[region.name] = np.frombuffer(data, dtype=region.dtype, count=count, offset=offset)
    image = MemoryImage(regions)
    _check(image)
    return image


def pack_beats(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """... x 3 coordinates below 2^24 as beats of 72 bits: their low 64 bits (uint64) and highest 8 (uint8)."""
    x, y, z = np.moveaxis(np.asarray(vertices, dtype=np.uint64), -1, 0)
    shift = np.uint64(COORDINATE_BITS)
    return x | y << shift | z << 2 * shift, (z >> np.uint64(64 - 2 * COORDINATE_BITS)).astype(np.uint8)


def unpack_beats(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The ... x 3 int64 coordinates in beats of 72 bits."""
    shift, mask = np.uint64(COORDINATE_BITS), np.uint64((1 << COORDINATE_BITS) - 1)
    z = low >> 2 * shift | high.astype(np.uint64) << np.uint64(64 - 2 * COORDINATE_BITS)
    return np.stack([low & mask, low >> shift & mask, z], axis=-1).astype(np.int64)


def layout_tables() -> str:
    """The layout as Markdown: the header, the region table, and one table for each region."""
    lines = []
    for region in (HEADER, ENTRY, *REGIONS):
        size = region.dtype.itemsize
        kept = "" if region in (HEADER, ENTRY) else f" Life: {region.life}."
        lines += [f"### {region.name}", "", f"{region.about}{kept} One record of {size} bytes per {region.record}.", "",
                  "| byte | field | type | meaning |", "|---|---|---|---|"]
        for field in region.fields:
            count = f" x {field.count}" if field.count > 1 else ""
            lines.append(f"| {region.dtype.fields[field.name][1]} | `{field.name}` | {field.type}{count} | "
                         f"{field.about} |")
        lines.append("")
    return "\n".join(lines)


def _aligned(size):
    return -(-size // ALIGNMENT) * ALIGNMENT


def _records(region, length, **fields):
    """Records of a region with these fields, 0 elsewhere; what does not fit its field is an error."""
    (layout,) = (one for one in REGIONS if one.name == region)
    records = np.zeros(length, dtype=layout.dtype)
    for name, value in fields.items():
        value = np.asarray(value)
        if value.size and value.dtype.kind in "iu":
            limits = np.iinfo(records[name].dtype)
            if value.min() < limits.min or value.max() > limits.max:
                raise InputError(f"memory image: {region}.{name} must be {limits.min} to {limits.max}, "
                                 f"not {value.min()} to {value.max()}")
        records[name] = value
    return records


def _listed(entries, cluster, first, count):
    return entries[int(cluster[first]):int(cluster[first]) + int(cluster[count])]


def _scene_regions(geometry, table):
    low, high = pack_beats(geometry.vertices)
    top = np.zeros((len(geometry), 8), dtype=np.uint8)
    top[:, 1:BEATS] = high
    listed = table.patches.read(np.arange(len(table.patches)))
    return {"cell_grid": _records("cell_grid", 1, lower=table.lower, cell=table.cell, shape=table.shape),
            "cells": _records("cells", len(table), pointer=table.pointer, count=table.count),
            "patch_lists": _records("patch_lists", len(listed), patch=listed),
            "patches": _records("patches", len(geometry), id=np.arange(len(geometry)), surface=geometry.surface,
                                top=top, vertex=low)}


def _phase_regions(plan, patches):
    cluster, address = plan.sets.residence(patches)
    residents = [len(held) for held in plan.sets.patches]
    subshells = [len(listed) for listed in plan.subshells]
    borders = plan.partition.levels[-1]
    return {"residence": _records("residence", patches, cluster=cluster, address=address),
            "clusters": _records("clusters", len(borders), first_column=borders[:, 0], end_column=borders[:, 1],
                                 first_row=borders[:, 2], end_row=borders[:, 3], processor=plan.processor,
                                 first_subshell=_starts(subshells), subshells=subshells,
                                 first_resident=_starts(residents), residents=residents),
            "subshells": _records("subshells", sum(subshells),
                                  patch=np.concatenate([listed.patches for listed in plan.subshells]),
                                  shell=np.concatenate([listed.shell for listed in plan.subshells])),
            "residents": _records("residents", sum(residents), patch=plan.sets.chosen)}


def _frustum_regions(record, table, config, weights):
    is_screen = record.is_screen
    frustum = _records("frustum", 1, is_screen=int(is_screen), half_angles=record.half_angles,
                       place=table.place(record.origin),
                       longest_direction=0 if is_screen else record.longest_direction, **{
        name: np.ravel(getattr(record, name)) for name in
        ("source", "columns", "rows", "column_bits", "row_bits", "origin", "matrix", "to_global", "z_scale")})
    return {"frustum": frustum, "columns": _records("columns", record.columns, table=_pairs(record.column_table)),
            "rows": _records("rows", record.rows, table=_pairs(record.row_table),
                             weight=0 if weights is None else weights,
                             slack=0 if is_screen else SphericalWindows(record, config).azimuth_slack)}


def _shell_regions(record, table, config):
    unit = CellTraversalUnit(record, table)
    shells = range(2, unit.last_shell + 1)
    rays = [unit.rays(shell) for shell in shells]
    rows, columns = [one.rows for one in rays], [one.columns for one in rays]

    def joined(name):
        return np.concatenate([getattr(one, name) for one in rays]) if rays else np.empty(0, dtype=np.int64)

    borders = np.array([unit.borders(shell) for shell in shells], dtype=np.int64).reshape(-1, 2)
    cells = unit.open(1, np.ones((record.rows, record.columns), dtype=bool))
    tables = [_pairs(joined(name)) for name in ("row_table", "column_table")]
    return {"near_cells": _records("near_cells", len(cells), cell=cells),
            "shells": _records("shells", len(shells), begin=borders[:, 0], end=borders[:, 1],
                               threshold=[unit.threshold(shell, config) for shell in shells],
                               row_border=[one.row_border for one in rays], first_row=_starts(rows), rows=rows,
                               first_column=_starts(columns), columns=columns,
                               first_ray=_starts(np.multiply(rows, columns))),
            "grid_rows": _records("grid_rows", sum(rows), table=tables[0], position=joined("row_position"),
                                  first_near=joined("first_row"), near=joined("row_count"),
                                  column_reach=joined("column_reach"), column_border=joined("column_border")),
            "grid_columns": _records("grid_columns", sum(columns), table=tables[1],
                                     position=joined("column_position"))}


def _pairs(table):
    """A table with a second column of 0 if it has one only."""
    return np.pad(table, ((0, 0), (0, 2 - table.shape[1]))) if table.size else np.zeros((0, 2), dtype=np.int64)


def _starts(counts):
    return np.cumsum([0, *counts])[:-1].astype(np.int64) if len(counts) else np.empty(0, dtype=np.int64)


def _check(image):
    """Every pointer stays within the table that it points into."""
    patches, cells = len(image["patches"]), len(image["cells"])
    for region in "cell_grid", "frustum":
        _require(len(image[region]) == 1, f"{region} must be one record")
    (grid,), (frustum,) = image["cell_grid"], image["frustum"]
    columns, rows = int(frustum["columns"]), int(frustum["rows"])
    _require(np.prod(grid["shape"].astype(np.uint64)) == cells, "cells must be as many as cell_grid.shape says")
    _within(image["cells"]["pointer"], image["cells"]["count"], len(image["patch_lists"]), "cells", "patch_lists")
    for region in "patch_lists", "subshells", "residents":
        _require((image[region]["patch"] < patches).all(), f"{region}.patch must be below {patches}")
    _require((image["near_cells"]["cell"] < cells).all(), f"near_cells.cell must be below {cells}")
    clusters = image["clusters"]
    for axis, end in ("column", columns), ("row", rows):
        first, last = clusters[f"first_{axis}"], clusters[f"end_{axis}"]
        _require(((first < last) & (last <= end)).all(), f"clusters: sections must lie within the {axis}s")
    _within(clusters["first_subshell"], clusters["subshells"], len(image["subshells"]), "clusters", "subshells")
    _within(clusters["first_resident"], clusters["residents"], len(image["residents"]), "clusters", "residents")
    shells = image["shells"]
    _within(shells["first_row"], shells["rows"], len(image["grid_rows"]), "shells", "grid_rows")
    _within(shells["first_column"], shells["columns"], len(image["grid_columns"]), "shells", "grid_columns")
    for region, count in (("columns", columns), ("rows", rows), ("hits", columns * rows), ("residence", patches),
                          ("sums", patches + 1)):
        _require(len(image[region]) == count, f"{region} must be {count} records, not {len(image[region])}")


def _within(first, count, length, region, table):
    ends = first.astype(np.uint64) + count.astype(np.uint64)
    _require((ends <= length).all(), f"{region} must point into the {length} records of {table}")


def _require(condition, requirement):
    if not condition:
        raise InputError(f"memory image: {requirement}")
