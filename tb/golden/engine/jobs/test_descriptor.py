"""Descriptors: bytes at the offsets of the specification, and every rule at its limit and one beyond."""

import struct

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.screen import Screen
from golden.engine.config import PRESETS
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import screen_record
from golden.engine.jobs.descriptor import (
    ANY_CLUSTER,
    DESCRIPTOR,
    RULES,
    check_descriptor,
    frustum_descriptor,
    load_descriptor,
    section_of,
    section_tiles,
)
from golden.engine.jobs.result_formats import HitFormat
from golden.scene.open import open_scene
from tb.golden.engine.schedule.scenes import case

# 4096 rays in tiles of 4 x 4, sides of up to 1024, four clusters.
CONFIG = PRESETS["small"]
SECTION = Sector(64, 128, 16, 32)


@pytest.fixture(scope="module", params=["hemisphere", "screen"])
def scene(request):
    made = case("lobby")
    if request.param == "screen":
        screen = Screen(camera=open_scene("lobby").camera, width=128, height=50)
        return screen_record(screen, made.geometry.coordinates), made.shelling.table
    return made.record, made.shelling.table


@pytest.fixture(scope="module")
def frustum(scene):
    return frustum_descriptor(*scene, section=SECTION, tag=0xDEADBEEF, hit_format=HitFormat.COMPACT, sums=True,
                              cluster=3, hits=0x123456780, sums_address=0x40, near_cells_address=0x98)


def changed(descriptor, **fields):
    other = np.array([descriptor])
    for name, value in fields.items():
        other[name] = value
    return other[0]


def test_bytes_are_where_the_specification_says(scene, frustum):
    record, table = scene
    data = frustum.tobytes()
    assert len(data) == 192
    assert struct.unpack_from("<HBBBBHII", data) == (1, 0, 2, 1, 0, 3, 0xDEADBEEF, 0)
    assert struct.unpack_from("<QQ4HQ4I", data, 16) == (
        0x123456780, 0x40, 64, 128, 16, 32, 0x98, len(near_cells(record, table, record.slopes)),
        CellTraversalUnit(record, table).last_shell, 0, 0)
    assert struct.unpack_from("<Ii4I3I", data, 64) == (
        record.bundle, record.source, record.columns, record.rows, record.column_bits, record.row_bits,
        *record.origin)
    assert struct.unpack_from("<18iI", data, 100) == (*record.matrix.ravel(), *record.to_global.ravel(),
                                                      record.z_scale)
    assert struct.unpack_from("<3iI", data, 176) == (
        *table.position(record.origin), 0 if record.is_screen else record.longest_direction)


def test_a_load_has_its_image_and_regions_and_nothing_else():
    data = load_descriptor(0x4000, 0x1FFF, tag=7).tobytes()
    assert struct.unpack_from("<HBBBBHIIQ", data) == (1, 1, 0, 0, 0, 0xFFFF, 7, 0x1FFF, 0x4000)
    assert not any(data[24:])
    data = load_descriptor(0x4000, 0x1FFF, tag=7, copies=True).tobytes()
    assert struct.unpack_from("<HBBBBHIIQ", data) == (1, 1, 0, 0, 0, 0, 7, 0x1FFF, 0x4000)


def test_the_whole_frustum_is_the_default(scene):
    record, table = scene
    assert section_of(frustum_descriptor(record, table)) == Sector.whole(record)


def test_a_section_beyond_its_field_is_refused(scene):
    with pytest.raises(InputError, match=r"descriptor\.end_column must be 0 to 65535, not 65536"):
        frustum_descriptor(*scene, section=Sector(65000, 65536, 0, 1))


ADDRESS_BITS = CONFIG.memory.address_bits
WHOLE = {"first_column": 0, "end_column": 128, "first_row": 0, "end_row": 32}
# Of a section: what is changed, and the code, or None where the limit is met.
LIMITS = [
    ("version", {"version": 0}, "DESCRIPTOR"), ("version", {"version": 2}, "DESCRIPTOR"),
    ("kind", {"kind": 2}, "DESCRIPTOR"), ("kind", {"kind": 255}, "DESCRIPTOR"),
    ("hit_format", {"hit_format": 0}, None), ("hit_format", {"hit_format": 3}, None),
    ("hit_format", {"hit_format": 4}, "DESCRIPTOR"),
    ("sums", {"sums": 0}, None), ("sums", {"sums": 2}, "DESCRIPTOR"),
    ("context", {"context": 1}, "DESCRIPTOR"),
    ("cluster", {"cluster": 0}, None), ("cluster", {"cluster": 4}, "DESCRIPTOR"),
    ("cluster", {"cluster": ANY_CLUSTER}, None), ("cluster", {"cluster": ANY_CLUSTER - 1}, "DESCRIPTOR"),
    ("hits", {"hits": 0}, None), ("hits", {"hits": 32}, "DESCRIPTOR"), ("hits", {"hits": 63}, "DESCRIPTOR"),
    ("sums_address", {"sums_address": 8}, "DESCRIPTOR"),
    ("near_cells", {"near_cells": 8}, None), ("near_cells", {"near_cells": 4}, "DESCRIPTOR"),
    *((name, {name: (1 << ADDRESS_BITS) + more}, code) for name in ("hits", "sums_address", "near_cells")
      for more, code in ((-64, None), (0, "DESCRIPTOR"))),
    ("near_count", {"near_count": 0}, None), ("near_count", {"near_count": 512}, None),
    ("near_count", {"near_count": 513}, "DESCRIPTOR"),
    ("last_shell", {"last_shell": 0}, "DESCRIPTOR"), ("last_shell", {"last_shell": 1}, None),
    ("last_shell", {"last_shell": 63}, None), ("last_shell", {"last_shell": 64}, "DESCRIPTOR"),
    ("reserved", {"reserved": 1 << 31}, "DESCRIPTOR"),
    ("ray_count", {"ray_count": 1}, "DESCRIPTOR"),
    ("bundle", {"bundle": 0}, None), ("bundle", {"bundle": 2}, "DESCRIPTOR"),
    *((name, {name: count}, code) for name in ("columns", "rows") for count, code in (
        (1 << CONFIG.icu.side_bits, None), ((1 << CONFIG.icu.side_bits) + 1, "DESCRIPTOR"))),
    # Empty by a column and by a row, and of one ray.
    ("first_column", {"end_column": 64}, "SECTION"), ("first_column", {"end_row": 16}, "SECTION"),
    ("first_column", {"end_column": 63}, "SECTION"), ("first_column", {"end_column": 65, "end_row": 17}, None),
    # The end of the frustum, and one beyond.
    ("first_column", {**WHOLE, "columns": 128, "rows": 32}, None),
    ("first_column", {**WHOLE, "columns": 127}, "SECTION"), ("first_column", {**WHOLE, "rows": 31}, "SECTION"),
    # Sides that the machine has tables for.
    ("first_column", {"first_column": 1023, "end_column": 1024, "columns": 1024}, None),
    ("first_column", {"first_column": 1023, "end_column": 1025, "columns": 2000}, "SECTION"),
    ("first_column", {"first_row": 1023, "end_row": 1025, "rows": 2000}, "SECTION"),
    # 256 tiles are the ray memory: rays of unfinished tiles take a whole one.
    ("first_column", {**WHOLE, "end_column": 253, "columns": 999, "end_row": 13, "rows": 999}, None),
    ("first_column", {**WHOLE, "end_column": 257, "columns": 999, "end_row": 13, "rows": 999}, "SECTION"),
    ("first_column", {**WHOLE, "end_column": 256, "columns": 999, "end_row": 17, "rows": 999}, "SECTION"),
]


# Of a machine whose numbers do not fit all formats.
WIDE = CONFIG.replace({"icu.uv_bits": 9, "icu.patch_bits": 23})
COMPACT = {"hit_format": HitFormat.COMPACT, "sums": 0}


@pytest.mark.parametrize("change", [{"icu.uv_bits": 9}, {"numbers.fraction_bits": 19}, {"icu.patch_bits": 23}])
def test_results_that_the_machine_cannot_represent_are_refused(frustum, change):
    config = CONFIG.replace(change)
    assert (check_descriptor(changed(frustum, **COMPACT), config) is None) == ("icu.patch_bits" in change)
    refusal = check_descriptor(changed(frustum, hit_format=HitFormat.FULL, sums=1), config)
    assert (refusal and refusal.byte) == (DESCRIPTOR.dtype.fields["sums"][1] if "icu.patch_bits" in change else None)


@pytest.mark.parametrize(("field", "change", "code"), LIMITS, ids=lambda value: str(value))
def test_every_rule_at_its_limit_and_beyond(frustum, field, change, code):
    refusal = check_descriptor(changed(frustum, **change), CONFIG)
    if code is None:
        assert refusal is None
    else:
        assert (refusal.code, refusal.byte) == (code, DESCRIPTOR.dtype.fields[field][1])


# Of a machine with shadow frusta.
SHADOW, BITS = CONFIG.replace({"icu.shadow_bits": 4}), {"bundle": 2, "hit_format": 0, "sums": 0}


@pytest.mark.parametrize(("field", "change", "code"), [
    ("bundle", BITS, None), ("bundle", {**BITS, "bundle": 3}, "DESCRIPTOR"),
    ("bundle", {**BITS, "hit_format": 1}, "DESCRIPTOR"), ("bundle", {**BITS, "sums": 1}, "DESCRIPTOR"),
    ("ray_count", {**BITS, "ray_count": 16}, None), ("ray_count", {**BITS, "ray_count": 17}, "DESCRIPTOR"),
    *(("bundle", {"bundle": bundle, "ray_count": 1}, "DESCRIPTOR") for bundle in (0, 1))], ids=str)
def test_shadow_frusta_have_lists_of_rays_and_no_other_results(frustum, field, change, code):
    refusal = check_descriptor(changed(frustum, **change), SHADOW)
    assert (refusal and (refusal.code, refusal.byte)) == (code and (code, DESCRIPTOR.dtype.fields[field][1]))


def test_every_rule_is_broken_above(frustum):
    broken = {check_descriptor(changed(frustum, **change), CONFIG).reason for _, change, code in LIMITS if code}
    broken.add(check_descriptor(changed(load_descriptor(64, 1), cluster=1), CONFIG).reason)
    broken |= {check_descriptor(changed(frustum, **change), WIDE).reason for change in (
        COMPACT, {"hit_format": HitFormat.NONE, "sums": 1})}
    broken |= {check_descriptor(changed(frustum, **change), SHADOW).reason for change in (
        {"bundle": 0, "ray_count": 1}, {"bundle": 2, "hit_format": 1})}
    assert broken == {rule.about for rule in RULES}


def test_rules_are_in_the_order_of_the_fields_and_the_first_one_decides(frustum):
    fields = [DESCRIPTOR.dtype.fields[rule.field][1] for rule in RULES]
    assert fields == sorted(fields)
    broken = changed(frustum, version=9, kind=9, reserved=1)
    assert check_descriptor(broken, CONFIG).byte == 0
    assert check_descriptor(changed(broken, version=1), CONFIG).byte == 2
    assert check_descriptor(changed(broken, version=1, kind=0), CONFIG).byte == 60


@pytest.mark.parametrize(("change", "byte"), [
    ({"hits": 32}, 16), ({"cluster": 4}, 6), ({"cluster": 1}, 6), ({"cluster": 0}, None), ({"context": 1}, 5),
    ({"reserved": 1}, 60), ({"ray_count": 1}, 56), ({"version": 0}, 0),
    ({"hit_format": 9, "sums": 9, "sums_address": 1, "near_count": 1 << 31, "near_cells": 1}, None)])
def test_a_load_has_the_rules_of_its_own_fields(change, byte):
    refusal = check_descriptor(changed(load_descriptor(64, 1), **change), CONFIG)
    assert (refusal and refusal.byte) == byte


def test_tiles_are_counted_from_the_corner_of_the_section():
    assert section_tiles(Sector(3, 5, 7, 9), CONFIG) == 1
    assert section_tiles(Sector(0, 5, 0, 4), CONFIG) == 2
    assert section_tiles(Sector(0, 5, 0, 9), CONFIG) == 6
