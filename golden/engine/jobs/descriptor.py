"""The descriptor: one entry of the ring that the host fills, a section of a frustum or a load of tables."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.ray_list import RAY_WORD, pack_rays
from golden.engine.jobs.result_formats import HitFormat, exceeding
from golden.engine.memory_map.layout import ALIGNMENT, FRUSTUM_FIELDS, Field, Region
from golden.engine.memory_map.records import frustum_fields, make_records
from golden.engine.memsys.patches.cell_table import CellTable

__all__ = ["ANY_CLUSTER", "DESCRIPTOR", "NEAR_ALIGNMENT", "RULES", "VERSION", "Kind", "Refusal", "Rule",
           "check_descriptor", "frustum_descriptor", "list_words", "load_descriptor", "near_bytes", "section_of",
           "section_tiles"]

VERSION = 1
# Of the field `cluster`: the first one that is free; of a load, each cluster its own tables.
ANY_CLUSTER = 0xFFFF
# The address of the cells of shell 1 is a multiple of this; all other addresses are multiples of `ALIGNMENT`.
NEAR_ALIGNMENT = 8
_OWNER = "descriptor"


class Kind(IntEnum):
    """What a descriptor requests."""

    FRUSTUM = 0
    LOAD = 1


DESCRIPTOR = Region("descriptor", "job", "entry of the ring", "A section of a frustum, or a load. Matrix entries are "
                    "signed 1.16.", (
    Field("version", "u2", f"{VERSION}"),
    Field("kind", "u1", "0: section of a frustum, 1: load"),
    Field("hit_format", "u1", "0: no hits, 1: 16 bytes a ray, 2: 8 bytes, 3: patch ids of 4 bytes"),
    Field("sums", "u1", "1: sparse sums are written; 0: not"),
    Field("context", "u1", "0"),
    Field("cluster", "u2", f"section: the cluster that must cast it, {ANY_CLUSTER:#x}: any; load: {ANY_CLUSTER:#x}: "
          "each cluster gets its own tables, 0: all clusters get those of cluster 0, which are read once"),
    Field("tag", "u4", "the host's; the completion record returns it"),
    Field("regions", "u4", "load: the regions of the image to read, bit k is region k; section: 0"),
    Field("hits", "u8", "section: address of the hit of ray (0, 0) of the frustum, or of the bits of its list; load: "
          f"of the image; a multiple of {ALIGNMENT}"),
    Field("sums_address", "u8", f"address of the sums, a multiple of {ALIGNMENT}"),
    Field("first_column", "u2", "section"),
    Field("end_column", "u2", "section"),
    Field("first_row", "u2", "section"),
    Field("end_row", "u2", "section"),
    Field("near_cells", "u8", f"address of the cells of shell 1, a u4 each; a multiple of {NEAR_ALIGNMENT}"),
    Field("near_count", "u4", "cells of shell 1"),
    Field("last_shell", "u4", "grid rays end with this shell; at least 1"),
    Field("ray_count", "u4", "shadow frustum: rays of its list, a u8 each, which begins with the first multiple of 8 "
          "bytes behind the cells of shell 1"),
    Field("reserved", "u4", "0"),
    *FRUSTUM_FIELDS,
))


def frustum_descriptor(record: FrustumRecord, table: CellTable, *, section: Sector | None = None, tag: int = 0,
                       hit_format: HitFormat = HitFormat.NONE, sums: bool = False, cluster: int = ANY_CLUSTER,
                       hits: int = 0, sums_address: int = 0, near_cells_address: int = 0) -> np.void:
    """The descriptor of a section of a frustum.

    Parameters
    ----------
    record, table
        The frustum, and the cells of its scene.
    section
        Rays of the frustum. Default: all of them.
    tag, hit_format, sums, cluster, hits, sums_address
        As the fields.
    near_cells_address
        Where the `near_bytes` are.

    Raises
    ------
    InputError
        A value is out of its field's range: a section ends beyond column or row 65535.
    """
    section = section or Sector.whole(record)
    return make_records(DESCRIPTOR, 1, _OWNER, {
        "version": VERSION, "kind": Kind.FRUSTUM, "hit_format": hit_format, "sums": int(sums), "cluster": cluster,
        "tag": tag, "hits": hits, "sums_address": sums_address, **vars(section), "near_cells": near_cells_address,
        "near_count": len(near_cells(record, table, record.slopes)),
        "ray_count": len(section.among(record.listed, record)) if record.bundle == Bundle.SHADOW else 0,
        "last_shell": CellTraversalUnit(record, table).last_shell, **frustum_fields(record, table)})[0]


def near_bytes(record: FrustumRecord, table: CellTable, section: Sector) -> bytes:
    """What a descriptor's ``near_cells`` points to: the cells of shell 1; behind them a shadow frustum's rays."""
    cells = near_cells(record, table, record.slopes).astype("<u4").tobytes()
    if record.bundle != Bundle.SHADOW:
        return cells
    return cells + bytes(-len(cells) % RAY_WORD.itemsize) + pack_rays(
        record, section.among(record.listed, record)).tobytes()


def list_words(descriptors: np.ndarray) -> np.ndarray:
    """Words of 8 bytes that the machine reads with each descriptor: cells of shell 1, two in each, and listed rays."""
    return (descriptors["near_count"].astype(np.int64) + 1) // 2 + descriptors["ray_count"]


def load_descriptor(image: int, regions: int, *, tag: int = 0, copies: bool = False) -> np.void:
    """The descriptor of a load.

    Parameters
    ----------
    image
        Address of the image.
    regions
        The regions to read, bit k is region k of the image.
    tag
        As the field.
    copies
        All clusters get the tables of cluster 0.

    Raises
    ------
    InputError
        A value is out of its field's range.
    """
    return make_records(DESCRIPTOR, 1, _OWNER, {
        "version": VERSION, "kind": Kind.LOAD, "cluster": 0 if copies else ANY_CLUSTER, "tag": tag, "regions": regions,
        "hits": image})[0]


def section_of(descriptor: np.void) -> Sector:
    """Rays of the section."""
    return Sector(*(int(descriptor[name]) for name in ("first_column", "end_column", "first_row", "end_row")))


def section_tiles(section: Sector, config: Config) -> int:
    """Tiles of the settle map, and of the ray memory, that a section takes."""
    side = 1 << config.icu.tile_bits
    return (-(-(section.end_column - section.first_column) // side)) * (-(-(section.end_row - section.first_row)
                                                                          // side))


@dataclass(frozen=True)
class Refusal:
    """Why the machine does not execute a descriptor.

    Parameters
    ----------
    code
        Name of the error code.
    byte
        What the completion record has as its address: the field's first byte in the descriptor.
    reason
        The rule that the descriptor breaks.
    """

    code: str
    byte: int
    reason: str


@dataclass(frozen=True)
class Rule:
    """What must hold of a descriptor.

    Parameters
    ----------
    field
        The field concerned, the first one of several.
    about
        The rule.
    holds
        Whether it holds of a descriptor on a machine of a configuration.
    kinds
        The descriptors that the rule is about.
    code
        Name of the error code.
    """

    field: str
    about: str
    holds: Callable[[np.void, Config], bool]
    kinds: tuple[Kind, ...] = (Kind.FRUSTUM, Kind.LOAD)
    code: str = "DESCRIPTOR"


def _aligned(field, multiple):
    return lambda one, config: int(one[field]) % multiple == 0 and int(one[field]) < 1 << config.memory.address_bits


def _small(field):
    return lambda one, config: one[field] <= 1 << config.icu.side_bits


def _is_inside(one, config):
    section = section_of(one)
    sides = (section.end_column, int(one["columns"])), (section.end_row, int(one["rows"]))
    return all(end <= count and end <= 1 << config.icu.side_bits for end, count in sides)


_FRUSTUM = (Kind.FRUSTUM,)
# In the order of the fields: the first rule that does not hold decides.
RULES = (
    Rule("version", f"version must be {VERSION}", lambda one, config: one["version"] == VERSION),
    Rule("kind", "kind must be 0 or 1", lambda one, config: one["kind"] in tuple(Kind)),
    Rule("hit_format", "hit_format must be 0 to 3", lambda one, config: one["hit_format"] in tuple(HitFormat),
         _FRUSTUM),
    Rule("hit_format", "the machine's numbers must have at most the bits of hit_format",
         lambda one, config: not exceeding(config, one["hit_format"], sums=False), _FRUSTUM),
    Rule("sums", "sums must be 0 or 1", lambda one, config: one["sums"] <= 1, _FRUSTUM),
    Rule("sums", "sums must be 0 if the machine's patch ids have more bits than those of sums",
         lambda one, config: not exceeding(config, HitFormat.NONE, sums=bool(one["sums"])), _FRUSTUM),
    Rule("context", "context must be 0", lambda one, config: one["context"] == 0),
    Rule("cluster", f"cluster must be below the number of clusters, or {ANY_CLUSTER:#x}",
         lambda one, config: one["cluster"] < config.noc.clusters or one["cluster"] == ANY_CLUSTER),
    Rule("cluster", f"cluster must be 0 or {ANY_CLUSTER:#x} of a load",
         lambda one, config: one["cluster"] in (0, ANY_CLUSTER), (Kind.LOAD,)),
    Rule("hits", f"hits must be a multiple of {ALIGNMENT} below 2^memory.address_bits", _aligned("hits", ALIGNMENT)),
    Rule("sums_address", f"sums_address must be a multiple of {ALIGNMENT} below 2^memory.address_bits",
         _aligned("sums_address", ALIGNMENT), _FRUSTUM),
    Rule("first_column", "the section must have rays",
         lambda one, config: one["first_column"] < one["end_column"] and one["first_row"] < one["end_row"],
         _FRUSTUM, "SECTION"),
    Rule("first_column", "the section must lie within the frustum, and within 2^icu.side_bits columns and rows",
         _is_inside, _FRUSTUM, "SECTION"),
    Rule("first_column", "the section must have at most the tiles of the ray memory",
         lambda one, config: section_tiles(section_of(one), config) <= config.icu.rays >> 2 * config.icu.tile_bits,
         _FRUSTUM, "SECTION"),
    Rule("near_cells", f"near_cells must be a multiple of {NEAR_ALIGNMENT} below 2^memory.address_bits",
         _aligned("near_cells", NEAR_ALIGNMENT), _FRUSTUM),
    Rule("near_count", "near_count must be at most 2^ctu.near_cell_bits",
         lambda one, config: one["near_count"] <= 1 << config.ctu.near_cell_bits, _FRUSTUM),
    Rule("last_shell", "last_shell must be 1 to 2^ctu.shell_bits - 1",
         lambda one, config: 1 <= one["last_shell"] < 1 << config.ctu.shell_bits, _FRUSTUM),
    Rule("ray_count", "ray_count must be at most 2^icu.shadow_bits, and 0 without shadow frusta",
         lambda one, config: one["ray_count"] <= config.icu.listed_rays),
    Rule("reserved", "reserved must be 0", lambda one, config: one["reserved"] == 0),
    Rule("bundle", "bundle must be 0 or 1, or 2 with icu.shadow_bits",
         lambda one, config: one["bundle"] <= (Bundle.SHADOW if config.icu.shadow_bits else Bundle.SCREEN), _FRUSTUM),
    Rule("bundle", "bundle must be 2 where there is a list of rays",
         lambda one, config: one["bundle"] == Bundle.SHADOW or not one["ray_count"], _FRUSTUM),
    Rule("bundle", "bundle must be 0 or 1 where hit_format or sums is not 0",
         lambda one, config: one["bundle"] != Bundle.SHADOW or not (one["hit_format"] or one["sums"]), _FRUSTUM),
    Rule("columns", "columns must be at most 2^icu.side_bits", _small("columns"), _FRUSTUM),
    Rule("rows", "rows must be at most 2^icu.side_bits", _small("rows"), _FRUSTUM),
)


def check_descriptor(descriptor: np.void, config: Config) -> Refusal | None:
    """The first of `RULES` that the descriptor breaks, or None: the machine of ``config`` executes it."""
    for rule in RULES:
        # Of an unknown kind, only the rules of these two fields are left.
        concerns = descriptor["kind"] in rule.kinds or rule.field in ("version", "kind")
        if concerns and not rule.holds(descriptor, config):
            return Refusal(rule.code, DESCRIPTOR.dtype.fields[rule.field][1], rule.about)
    return None
