"""The memory image: bytes and arrays hold the same, and broken images are refused."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.ctu import margins
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import screen_record
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.lib.fixed import round_shift
from golden.engine.memory_map import (
    ALIGNMENT,
    ENTRY,
    HEADER,
    MAGIC,
    REGIONS,
    VERSION,
    MemoryImage,
    from_bytes,
    pack_beats,
    phase_image,
    unpack_beats,
)
from golden.engine.schedule.phase import schedule
from golden.scene.open import open_scene
from hw.ctu.ctu_formats import CtuFormats
from tb.golden.engine.schedule.scenes import CONFIG, Case, case

WEIGHTS = Hemisphere(128, 32).polar_weights


@pytest.fixture(scope="module", params=["hemisphere", "screen"])
def scene(request):
    made = case("room1627")
    if request.param == "hemisphere":
        return made
    screen = Screen(camera=open_scene("room1627").camera, width=90, height=50)
    return Case(made.geometry, made.shelling, screen_record(screen, made.geometry.coordinates))


@pytest.fixture(scope="module")
def plan(scene):
    return schedule(scene.record, scene.geometry, scene.shelling.table, CONFIG, clusters=8, ratio=16, capacity=20,
                    topology="mesh")


@pytest.fixture(scope="module")
def image(scene, plan):
    return phase_image([scene.record], scene.geometry, scene.shelling.table, CONFIG, plan=plan,
                       weights=None if scene.record.is_screen else WEIGHTS)


@pytest.fixture(scope="module")
def back(image):
    return from_bytes(image.to_bytes())


def test_bytes_and_back_and_bytes_are_the_same_bytes(image, back):
    assert back.to_bytes() == image.to_bytes()
    for region in REGIONS:
        assert np.array_equal(back[region.name], image[region.name])


def test_grid_rays_can_be_made_from_the_tables_alone(scene, back):
    unit = CellTraversalUnit(scene.record, scene.shelling.table)
    assert len(back["shells"]) == unit.last_shell - 1
    for number, shell in enumerate(back["shells"]):
        rays = unit.rays(number + 2)
        rows = back["grid_rows"][shell["first_row"]:shell["first_row"] + shell["rows"]]
        columns = back["grid_columns"][shell["first_column"]:shell["first_column"] + shell["columns"]]
        down, across = rows["table"][:, None].astype(np.int64), columns["table"][None].astype(np.int64)
        if scene.record.is_screen:
            parts = np.broadcast_arrays(across[..., 0], down[..., 0], 1 << 16)
        else:
            parts = np.broadcast_arrays((down[..., 0] * across[..., 0] + (1 << 15)) >> 16,
                                        round_shift(down[..., 0] * across[..., 1], 16), down[..., 1])
        assert np.array_equal(np.stack(parts, axis=-1), rays.direction)
        assert np.array_equal(rows["first_near"], rays.first_row)
        assert np.array_equal(rows["near"], rays.row_count)
        reach, position = rows["column_reach"][:, None].astype(np.int64), columns["position"].astype(np.int64)
        first, last = -((reach + 128 - position) >> 8), (position + reach - 128) >> 8
        if scene.record.is_screen:
            first, last = np.maximum(first, 0), np.minimum(last, scene.record.columns - 1)
        count = np.clip(last - first + 1, 0, scene.record.columns)
        assert np.array_equal(count, rays.column_count)
        some = (count > 0) & (count < scene.record.columns)
        assert np.array_equal((first % scene.record.columns)[some], rays.first_column[some])
        assert (shell["begin"], shell["end"]) == unit.borders(number + 2)
        assert shell["threshold"] == unit.threshold(number + 2, CONFIG)
        assert shell["first_ray"] == sum(earlier["rows"] * earlier["columns"] for earlier in back["shells"][:number])


def test_ray_directions_can_be_made_from_the_tables_alone(scene, back):
    column, row = back["columns"]["table"].astype(np.int64), back["rows"]["table"].astype(np.int64)[:, None]
    if scene.record.is_screen:
        parts = np.broadcast_arrays(column[:, 0], row[..., 0], 1 << 16)
    else:
        parts = np.broadcast_arrays(round_shift(row[..., 0] * column[:, 0], 16),
                                    round_shift(row[..., 0] * column[:, 1], 16), row[..., 1])
    assert np.array_equal(np.stack(parts, axis=-1).reshape(-1, 3), scene.record.all_directions())


def test_bounds_of_windows_are_those_of_the_block(scene, back):
    slack = back["rows"]["slack"]
    if scene.record.is_screen:
        assert not slack.any()
    else:
        assert np.array_equal(slack, SphericalWindows(scene.record, CONFIG).azimuth_slack)


def test_weights_return(scene, back):
    assert np.array_equal(back["rows"]["weight"], [0] * scene.record.rows if scene.record.is_screen else WEIGHTS)
    assert int(back["rows"]["weight"].sum()) * scene.record.columns == (0 if scene.record.is_screen else 1 << 32)


def test_regions_are_aligned_and_apart(image):
    offsets = image.offsets
    end = HEADER.dtype.itemsize + len(REGIONS) * ENTRY.dtype.itemsize
    for region in REGIONS:
        assert offsets[region.name] % ALIGNMENT == 0
        assert offsets[region.name] >= end
        end = offsets[region.name] + image[region.name].nbytes
    assert end <= image.size == len(image.to_bytes())
    assert image.size % ALIGNMENT == 0, "an image ends with a beat of any width"


def test_offsets_are_those_of_the_region_table_and_need_no_bytes(image, monkeypatch):
    table = np.frombuffer(image.to_bytes(), dtype=ENTRY.dtype, count=len(REGIONS), offset=HEADER.dtype.itemsize)
    monkeypatch.delattr("golden.engine.memory_map.image.image_bytes")
    assert image.offsets == dict(zip((region.name for region in REGIONS), table["offset"].tolist(), strict=True))


def test_a_patch_is_read_without_crossing_a_page():
    (patches,) = (region for region in REGIONS if region.name == "patches")
    assert patches.dtype.itemsize == ALIGNMENT
    assert 4096 % ALIGNMENT == 0


def test_records_have_no_hidden_gaps_and_even_words():
    for region in (HEADER, ENTRY, *REGIONS):
        ends = [offset + size.itemsize for size, offset in region.dtype.fields.values()]
        starts = [offset for _, offset in region.dtype.fields.values()]
        assert starts == [0, *ends[:-1]]
        for field in region.fields:
            width = np.dtype(field.type).itemsize
            assert region.dtype.fields[field.name][1] % width == 0


def test_beats_hold_three_coordinates_of_24_bits():
    vertices = np.array([[0, 0, 0], [1, 2, 3], [(1 << 24) - 1] * 3, [0xABCDEF, 0x123456, 0xFEDCBA]])
    low, high = pack_beats(vertices)
    assert [int(top) << 64 | int(bottom) for bottom, top in zip(low, high, strict=True)] == [
        int(x) | int(y) << 24 | int(z) << 48 for x, y, z in vertices]
    assert np.array_equal(unpack_beats(low, high), vertices)


def broken(image, region, field, value, row=0):
    """The bytes of an image with one field changed."""
    copy = image[region].copy()
    copy[field][row] = value
    return MemoryImage({**image.regions, region: copy}).to_bytes()


@pytest.mark.parametrize(("region", "field", "value", "message"), [
    ("cells", "pointer", 1 << 31, "cells must point into the .* records of patch_lists"),
    ("cells", "count", 1 << 31, "cells must point into"),
    ("clusters", "residents", 9999, "clusters must point into the .* records of residents"),
    ("clusters", "first_subshell", 9999, "clusters must point into the .* records of subshells"),
    ("shells", "rows", 99999, "shells must point into the .* records of grid_rows"),
    ("shells", "first_column", 99999, "shells must point into the .* records of grid_columns"),
    ("cell_grid", "shape", 2, "cells must be as many as cell_grid.shape states"),
    ("shells", "rows", 1 << 12, "must"),
    ("shells", "first_ray", 1, r"shells.first_ray must be the number of grid rays of the shells before"),
    ("rows", "weight", 1 << 42, "rows.weight must be below 4398046511104"),
])
def test_tables_that_point_outside_are_refused(image, region, field, value, message):
    with pytest.raises(InputError, match=f"memory image: .*{message}"):
        from_bytes(broken(image, region, field, value))


@pytest.mark.parametrize(("region", "field", "table"), [
    ("patch_lists", "patch", "patches"), ("patches", "id", "patches"), ("subshells", "patch", "patches"),
    ("residents", "patch", "patches")])
def test_the_last_record_of_a_table_is_accepted_and_the_one_behind_it_refused(image, region, field, table):
    count = len(image[table])
    assert from_bytes(broken(image, region, field, count - 1))[region][field][0] == count - 1
    with pytest.raises(InputError, match=rf"{region}\.{field} must be below {count}"):
        from_bytes(broken(image, region, field, count))


def test_the_largest_weight_is_accepted(image):
    assert from_bytes(broken(image, "rows", "weight", (1 << 42) - 1))["rows"]["weight"][0] == (1 << 42) - 1


# Of the records that the machine keeps of grid rays, the fields with the format of a position or of a distance.
FORMATS = CtuFormats(CONFIG)
PLACES = [(region, name, field.shape) for region, record in (
    ("shells", FORMATS.grid_shell), ("grid_rows", FORMATS.grid_row), ("grid_columns", FORMATS.grid_column))
    for name, field in record if field.shape in (FORMATS.position, FORMATS.reach)]


@pytest.mark.parametrize(("region", "field", "shape"), PLACES)
def test_a_position_that_the_machine_cuts_off_is_refused(image, region, field, shape):
    most = (1 << shape.width - shape.signed) - 1
    for value in (most, -most * shape.signed):
        assert from_bytes(broken(image, region, field, value))[region][field][0] == value
    for value in (most + 1, -2 - most if shape.signed else 1 << 31):
        with pytest.raises(InputError, match=rf"{region}\.{field} must be below 2\^25 in magnitude; use a wider view"):
            from_bytes(broken(image, region, field, value))


@pytest.mark.parametrize("columns", [512, 4096])
def test_the_narrowest_view_is_the_one_whose_reaches_the_machine_holds(columns):
    """Reaches in columns are inverse to the view's width; those of shell 2 are the largest."""
    made, camera = case("room1627"), open_scene("room1627").camera
    config = CONFIG.replace({"icu.side_bits": 12})

    def image_of(share):
        """Of a screen of 16 rows, its width a share of one whose reach has all bits."""
        half = share * margins.screen_reach(2, 0, margins.RADIUS / np.sqrt(2), 1.125) * columns / 2 / (1 << 17)
        fov = np.degrees(2 * np.arctan(half * 16 / columns))
        record = screen_record(Screen(camera=replace(camera, fov=fov), width=columns, height=16),
                               made.geometry.coordinates)
        return phase_image([record], made.geometry, made.shelling.table, config)

    shells = image_of(1.01)["grid_rows"]
    assert 1 << 24 < shells["column_reach"].max() < 1 << 25
    with pytest.raises(InputError, match=r"must be below 2\^25 in magnitude"):
        image_of(0.99)


def grown(image, **records):
    """The image with other records of some regions."""
    return MemoryImage({**image.regions, **records})


def test_a_grid_that_the_machine_cannot_number_is_refused(image):
    grid = image["cell_grid"].copy()
    grid["shape"] = 1024, 1, 1
    large = grown(image, cell_grid=grid, cells=np.resize(image["cells"], 1024))
    with pytest.raises(InputError, match=r"cell_grid\.shape must be below 1024, not \[1024, 1, 1\]"):
        from_bytes(large.to_bytes())
    grid["shape"] = 1023, 1, 1
    from_bytes(grown(large, cell_grid=grid, cells=np.resize(image["cells"], 1023)).to_bytes())


@pytest.mark.parametrize(("rows", "columns", "message"), [
    (4095, 256, None), (4095, 257, "grid rays must be at most 1048576, not 1052415"),
    (4096, 1, "shells.rows must be below 4096"), (1, 4096, "shells.columns must be below 4096")])
def test_grid_rays_that_the_machine_cannot_number_are_refused(image, rows, columns, message):
    shells = image["shells"][:1].copy()
    shells["rows"], shells["columns"] = rows, columns
    large = grown(image, shells=shells, grid_rows=np.resize(image["grid_rows"], 4096),
                  grid_columns=np.resize(image["grid_columns"], 4096)).to_bytes()
    if message is None:
        from_bytes(large)
    else:
        with pytest.raises(InputError, match=f"memory image: {message}"):
            from_bytes(large)


def test_an_image_of_a_grid_that_the_machine_cannot_number_is_not_made(scene, plan, monkeypatch):
    monkeypatch.setattr("golden.engine.memory_map.check.GRID_SIDE_BITS", 3)
    with pytest.raises(InputError, match=r"shells\.rows must be below 8"):
        phase_image([scene.record], scene.geometry, scene.shelling.table, CONFIG, plan=plan)


def test_data_that_are_no_image_are_refused(image):
    data = image.to_bytes()
    with pytest.raises(InputError, match="too few"):
        from_bytes(data[:40])
    with pytest.raises(InputError, match=f"Magic must be {MAGIC}, not"):
        from_bytes(b"\0" * 4 + data[4:])
    for version in VERSION - 1, VERSION + 1:
        with pytest.raises(InputError, match=f"Version must be {VERSION}, not {version}"):
            from_bytes(data[:4] + bytes([version]) + data[5:])
    with pytest.raises(InputError, match="Size must be"):
        from_bytes(data[:-64])
    start = HEADER.dtype.itemsize
    with pytest.raises(InputError, match=r"region cell_grid.*outside"):
        from_bytes(data[:start] + b"\xc0\xff\xff\xff\xff\0\0\0" + data[start + 8:])
    with pytest.raises(InputError, match=r"region cell_grid.*outside"):
        from_bytes(data[:start] + b"\x41" + data[start + 1:])


def test_another_number_of_rays_than_was_scheduled_is_refused(scene, plan):
    other = case("room1627", rays=(64, 16)).record
    with pytest.raises(InputError, match=r"Frusta must have the schedule's .* rays, not 64 x 16"):
        phase_image([other], scene.geometry, scene.shelling.table, CONFIG, plan=plan)
