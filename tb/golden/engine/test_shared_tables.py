"""Tables that golden and the hardware share, each made again from its definition: a fault in one would be in both."""

import re
import struct
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import PRESETS, Config, Icu
from golden.engine.ctu import margins
from golden.engine.ctu.cell_traversal import reciprocal_table
from golden.engine.ctu.grid_rays import hemisphere_rays, screen_rays
from golden.engine.frustum import screen_record
from golden.engine.icu.edge_planes import EDGES
from golden.engine.icu.inverse_distance import decode
from golden.engine.icu.settle_code import settle_code, settle_floor
from golden.engine.memory_map import pack_beats, phase_image
from golden.engine.noc.packing import reply_flits, request_flits
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.schedule.phase import schedule
from golden.scene.camera import Camera
from golden.scene.open import open_scene
from tb.golden import precise
from tb.golden.engine.icu.patches import hemisphere
from tb.golden.engine.schedule.scenes import CONFIG, case

PAGE = Path(__file__).parents[3] / "docs" / "formats" / "images.md"
TYPES = {"u1": "B", "u2": "H", "u4": "I", "u8": "Q", "i4": "i", "f8": "d"}
ONE = 1 << 16


def turned(numerator, denominator):
    """Nearest integers to 2^16 times cosine and sine of a part of a turn."""
    angle = 2 * precise.pi() * numerator / denominator
    return [precise.nearest(ONE * precise.cos(angle)), precise.nearest(ONE * precise.sin(angle))]


@pytest.mark.parametrize(("azimuths", "polars"), [(4, 4), (64, 16), (8, 512), (1024, 4)])
def test_ray_tables_are_the_nearest_integers(azimuths, polars):
    record = hemisphere(azimuths, polars)
    assert record.column_table.tolist() == [turned(2 * k + 1, 2 * azimuths) for k in range(azimuths)]
    assert record.row_table.tolist() == [turned(2 * k + 1, 8 * polars)[::-1] for k in range(polars)]


@pytest.mark.parametrize("shell", [2, 5, 12])
def test_tables_of_grid_rays_are_the_nearest_integers(shell):
    rays = hemisphere_rays(shell, 64, 16)
    assert rays.column_table.tolist() == [turned(2 * k + 1, 2 * rays.columns) for k in range(rays.columns)]
    lowest = Decimal(np.pi / 2 + margins.horizon(shell))
    for row, (sine, cosine) in enumerate(rays.row_table.tolist()):
        angle = (row + Decimal("0.5")) * lowest / rays.rows
        assert sine == precise.nearest(ONE * precise.sin(angle))
        assert cosine == precise.nearest(ONE * precise.cos(angle))


def screen(width, height):
    """A picture's record; its camera does not matter for slopes."""
    camera = Camera(eye=(0.5, 0.5, 0.5), target=(0.5, 0.5, 1), up=(0, 1, 0), fov=53.0)
    return screen_record(Screen(camera=camera, width=width, height=height),
                         GCoordinates.of(open_scene("furnace:1"), CONFIG.numbers))


@pytest.mark.parametrize(("width", "height"), [(1, 2), (24, 18), (64, 33)])
def test_slopes_of_pixels_are_those_of_a_grid_of_powers_of_two(width, height):
    record = screen(width, height)
    for table, size in (record.column_table, width), (record.row_table, height):
        full = 2
        while full < size:
            full *= 2
        assert table.tolist() == [[precise.nearest(ONE * Decimal(2 * k + 1 - size) / full)] for k in range(size)]


@pytest.mark.parametrize("shell", [2, 5, 12])
def test_slopes_of_grid_rays_are_the_nearest_integers(shell):
    record = screen(24, 18)
    rays = screen_rays(shell, (24, 18), (record.column_bits, record.row_bits), record.half_angles)
    # The scale leaves an eighth beyond the largest slope, or beyond 1.
    scale = Decimal("1.125") * max(*map(Decimal, record.slopes), 1)
    for table, slope in (rays.column_table, record.slopes[0]), (rays.row_table, record.slopes[1]):
        border = Decimal(slope) + Decimal(float(margins.screen_border(shell, slope, float(scale))))
        assert table.ravel().tolist() == [precise.nearest(ONE * (Decimal(2 * k + 1) / len(table) - 1) * border / scale)
                                          for k in range(len(table))]


@pytest.mark.parametrize(("azimuths", "polars", "bits"), [(64, 16, 32), (512, 256, 32), (2048, 64, 40)])
def test_weights_are_differences_of_the_rounded_integral(azimuths, polars, bits):
    weights = Hemisphere(azimuths, polars).polar_weights.tolist()
    total = 0
    for row, weight in enumerate(weights):
        total += weight
        exact = precise.sin((row + 1) * precise.pi() / 2 / polars) ** 2 * 2**bits / azimuths
        # Float64 keeps the integral to a thousandth of a unit.
        assert abs(total - exact) < Decimal("0.501")
    assert total * azimuths == 1 << bits


def test_the_table_of_reciprocals_is_the_chord_lowered_by_half_its_sagitta():
    value, slope = reciprocal_table()
    for row in range(512):
        low, high = Fraction(512 + row, 512), Fraction(513 + row, 512)
        scale, width = 2**23, Fraction(1, 512)
        # An eighth of the squared width times 2 / x^3, half of which lowers the value; half a unit of eight raises it.
        sagitta = scale * width**2 / 8 * 2 / low**3 / 2
        assert value[row] == int(scale / low - sagitta + 4)
        assert slope[row] == round(scale / low - scale / high)


def test_edges_and_diagonals_are_in_the_order_of_the_documents():
    assert EDGES == ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3))


@pytest.mark.parametrize("icu", [Icu(), Icu(settle_bits=6, settle_fraction=3)], ids=str)
def test_settle_codes_are_floats_from_a_half(icu):
    config = Config(icu=icu)
    fraction = icu.settle_fraction
    assert settle_floor(np.array(0), config) == 0
    for code in range(1, 1 << icu.settle_bits):
        floor = int(settle_floor(np.array(code), config))
        exponent, rest = divmod(code, 1 << fraction)
        expected = Fraction(2) ** (exponent - 1) * (1 + Fraction(rest, 1 << fraction))
        assert Fraction(float(decode(np.array(floor), config.numbers))) == expected
        assert int(settle_code(np.array(floor), config)) == code
        assert int(settle_code(np.array(floor - 1), config)) == code - 1


def test_flits_are_those_of_an_example_by_hand():
    config = PRESETS["tiny"].replace({"noc.flit_bits": 40, "noc.check": "parity", "noc.columns": 4,
                                      "noc.rows": 2, "icu.patch_bits": 13})
    # Destination 5 in bits 0-2, source 3 in 3-5, patch 0x1234 in 6-18; one flit, first and last: parity of 8 + 2 ones.
    header = 5 | 3 << 3 | 0x1234 << 6
    assert header == 0x48D1D
    ones = bin(header).count("1")
    assert request_flits(config, source=3, destination=5, patch=0x1234) == [
        (header | (ones + 2) % 2 << 40, True, True)]
    vertices = [(1, 2, 3), (0xABCDEF, 0x123456, 0xFEDCBA), (0, 0, 0), (-1, 0, 0)]
    flits = reply_flits(config, source=3, destination=5, patch=0x1234, surface=-2, vertices=vertices)
    # Surface -2 above the header, from bit 19: 51 bits, so two flits; then 72 bits, two flits, for each vertex.
    words = [header | 0xFFFFFFFE << 19, 0x000003000002000001, 0xFEDCBA123456ABCDEF, 0, 0xFFFFFF]
    expected = [word >> shift & 0xFFFFFFFFFF for word in words for shift in (0, 40)]
    assert [flit[0] & 0xFFFFFFFFFF for flit in flits] == expected
    assert [flit[1:] for flit in flits] == [(True, False), *[(False, False)] * 8, (False, True)]
    for number, (flit, first, last) in enumerate(flits):
        assert flit >> 40 == (bin(expected[number]).count("1") + first + last) % 2


def test_a_patch_is_these_sixty_four_bytes():
    low, high = pack_beats(np.array([[0x030201, 0x060504, 0x090807], [0x0C0B0A, 0x0F0E0D, 0x121110]]))
    # x in the three lowest bytes, then y, then z, whose highest byte is apart.
    assert low.astype("<u8").tobytes() == bytes([1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 14, 15, 16, 17])
    assert high.tobytes() == bytes([9, 18])


@pytest.fixture(scope="module")
def made():
    scene = case("room1627")
    plan = schedule(scene.record, scene.geometry, scene.shelling.table, CONFIG, clusters=2, ratio=16, capacity=20,
                    topology="mesh")
    image = phase_image([scene.record], scene.geometry, scene.shelling.table, CONFIG, plan=plan,
                        weights=Hemisphere(scene.record.columns, scene.record.rows).polar_weights)
    return scene, plan, image


class Reader:
    """An image's bytes by the tables of docs/formats/images.md, in order: nothing of golden's layout."""

    def __init__(self, data):
        self._data, self._fields, self._size = data, {}, {}
        text = PAGE.read_text()
        for name, section in re.findall(r"### (.*)\n((?:(?!###).*\n?)*)", text):
            self._size[name] = int(re.search(r"One record of (\d+) bytes", section)[1])
            self._fields[name] = {field: (int(byte), TYPES[kind], int(count or 1)) for byte, field, kind, count in
                                  re.findall(r"^\| (\d+) \| `(\w+)` \| (\w\d)(?: x (\d+))? \|", section, re.M)}
        self.regions = list(self._fields)[2:]
        self._extent = {}
        for number, region in enumerate(self.regions):
            self._extent[region] = struct.unpack_from("<QQ", data, 16 + 16 * number)

    def fields(self, region):
        return list(self._fields[region])

    def count(self, region):
        return self._extent[region][1]

    def read(self, region, number, field):
        byte, kind, count = self._fields[region][field]
        values = struct.unpack_from(f"<{count}{kind}", self._data,
                                    self._extent[region][0] + number * self._size[region] + byte)
        return values if count > 1 else values[0]


def test_bytes_of_an_image_are_where_the_page_says(made):
    scene, plan, image = made
    data = image.to_bytes()
    reader, record, geometry, table = Reader(data), scene.record, scene.geometry, scene.shelling.table
    assert data[:4] == b"RADE"
    assert struct.unpack_from("<IQ", data, 4) == (3, len(data))
    assert len(reader.regions) == 13
    assert reader.count("patches") == len(geometry)
    for patch in range(0, len(geometry), 101):
        top, low = reader.read("patches", patch, "top"), reader.read("patches", patch, "vertex")
        beats = [int(word) | byte << 64 for word, byte in zip(low, top[1:5], strict=True)]
        assert [[beat >> 24 * axis & 0xFFFFFF for axis in range(3)] for beat in beats] \
            == geometry.vertices[patch].tolist()
        assert reader.read("patches", patch, "id") == patch
        assert reader.read("patches", patch, "surface") == geometry.surface[patch]
        assert reader.read("patches", patch, "kind") == 0
    assert reader.read("cell_grid", 0, "lower") == tuple(table.lower)
    assert reader.read("cell_grid", 0, "cell") == table.cell
    _, y, z = reader.read("cell_grid", 0, "shape")
    for index in np.ndindex(*table.shape):
        number = (index[0] * y + index[1]) * z + index[2]
        if number % 173 == 0:
            first = reader.read("cells", number, "pointer")
            entries = range(first, first + reader.read("cells", number, "count"))
            listed = [reader.read("patch_lists", entry, "patch") for entry in entries]
            assert listed == table.patches.read(table.entries(np.array([number]))).tolist()
    for column in range(0, record.columns, 7):
        assert list(reader.read("columns", column, "table")) == turned(2 * column + 1, 2 * record.columns)
    for row in range(record.rows):
        assert list(reader.read("rows", row, "table")) == turned(2 * row + 1, 8 * record.rows)[::-1]
    residents = subshells = 0
    for cluster, (held, listed, processor) in enumerate(zip(
            plan.sets.patches, plan.subshells, plan.processor, strict=True)):
        assert reader.read("clusters", cluster, "processor") == processor
        assert reader.read("clusters", cluster, "first_resident") == residents
        assert reader.read("clusters", cluster, "residents") == len(held)
        assert [reader.read("residents", residents + k, "patch") for k in range(len(held))] == held.tolist()
        assert all(reader.read("residence", int(patch), "cluster") == cluster for patch in held)
        assert reader.read("clusters", cluster, "first_subshell") == subshells
        assert reader.read("clusters", cluster, "subshells") == len(listed)
        residents, subshells = residents + len(held), subshells + len(listed)
    for shell in range(2, 2 + reader.count("shells")):
        assert reader.read("shells", shell - 2, "begin") == (shell - 1) << 16
        assert reader.read("shells", shell - 2, "end") == shell << 16
    assert reader.count("residence") == len(geometry)


def test_every_field_of_every_region_is_where_the_page_says(made):
    image = made[2]
    reader = Reader(image.to_bytes())
    for region in reader.regions:
        records = image[region]
        assert reader.count(region) == len(records)
        for number in {0, len(records) // 2, len(records) - 1} if len(records) else ():
            for field in reader.fields(region):
                value = reader.read(region, number, field)
                assert np.ravel(records[field][number]).tolist() == (
                    list(value) if isinstance(value, tuple) else [value]), (region, field)
