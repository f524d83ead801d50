"""Faults that model and hardware would share, put into golden: each is found by what shares nothing with golden.

The hardware is compared with golden, takes tables and constants from it, and follows the same pages; so a fault that is
in both changes no such comparison. Here golden has it, and the references must see it.
"""

import sys
from functools import cache, cached_property, partial
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType

import numpy as np
import pytest

from benchmarks.independent_hits import rule_hits
from benchmarks.viewpoints import CONFIG, hard_records
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import Icu, Numbers
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.camera import Camera
from golden.scene.open import open_scene
from tb.golden.engine import test_shared_tables
from tb.golden.engine.ctu import test_margins
from tb.golden.engine.icu import test_window_margins
from tb.golden.soups import soup

PACKAGES = ("benchmarks", "golden", "hw", "radiosity", "tb")
# A 64th of the cube in units of G.
STEP = 2**18


def put(monkeypatch, name, *texts):
    """Replace texts of a module, each by the one after it, for all who use its functions and its classes."""
    module, faulty = import_module(name), ModuleType(name)
    source = Path(module.__file__).read_text()
    for old, new in zip(texts[::2], texts[1::2], strict=True):
        assert source.count(old) == 1
        source = source.replace(old, new)
    exec(compile(source, module.__file__, "exec"), vars(faulty))
    ours = {}
    for member, value in vars(module).items():
        if getattr(value, "__module__", None) == name:
            if isinstance(value, type):
                # Instances that exist, such as the configuration, have the fault too.
                for own, change in vars(getattr(faulty, member)).items():
                    if isinstance(change, FunctionType | property | cached_property) and own != "__init__":
                        monkeypatch.setattr(value, own, change)
            else:
                ours[id(value)] = getattr(faulty, member)
    for user in [user for title, user in sys.modules.items() if title.partition(".")[0] in PACKAGES]:
        for member, value in [*vars(user).items()]:
            if id(value) in ours:
                monkeypatch.setattr(user, member, ours[id(value)])


def directed(patches):
    """Patches given in G around the cube's middle, and a hemisphere and a screen that look along z from there."""
    scene = open_scene("furnace:1")
    coordinates = GCoordinates.of(scene, CONFIG.numbers)
    vertices = np.array(patches) + 2**23
    geometry = PatchGeometry(coordinates=coordinates, vertices=vertices,
                             surface=np.arange(len(vertices), dtype=np.int32))
    eye = coordinates.points(np.full(3, 2**23))
    camera = Camera(eye=tuple(eye), target=tuple(eye + np.eye(3)[2]), up=(0, -1, 0), fov=90.0)
    return geometry, [hemisphere_record(Hemisphere(16, 16), coordinates, eye, (0, 0, 1), axes=np.eye(3)),
                      screen_record(Screen(camera=camera, width=17, height=17), coordinates)]


def quad(left, right, depth):
    """A square of 16 steps at a depth, its sides from ``left`` to ``right``."""
    return STEP * np.array([[left, -8, depth], [right, -8, depth], [right, 8, depth], [left, 8, depth]])


# Rays on the edge of two patches and of one; patches at one depth; a dart, which is not convex.
DART = STEP * np.array([[0, 6, 14], [8, -8, 14], [0, -2, 14], [-8, -8, 14]])
FRONT = [quad(-8, 0, 16), quad(0, 8, 16), quad(-6, -2, 16), DART]
# A plane at 1.5 units of R from the origin, which is dropped.
NEAR = [quad(-8, 8, 0) + np.array([0, 0, 6]), quad(-8, 8, 20)]
# Rounding has rays of the screen at y = 0 inside, but the plane rises from them.
GRAZING = [[[-STEP, 28, 6 * STEP], [STEP, 28, 6 * STEP], [4 * STEP, 45, 24 * STEP], [-4 * STEP, 45, 24 * STEP]]]


@cache
def battery():
    """Directed patches, a soup of slivers, and a room: geometry, records, and their hits by the rule of the pages."""
    cases = [*map(directed, (FRONT, NEAR, GRAZING)),
             hard_records(soup(2), origins=2, rays=(64, 32), pixels=(24, 18), seed=2),
             hard_records(open_scene("cornell"), origins=2, rays=(32, 16), pixels=(24, 18), seed=3)]
    return [(geometry, record, rule_hits(record, geometry)) for geometry, records in cases for record in records]


def is_found(geometry, record, rule):
    """Whether a ray's hit differs from the rule's."""
    hits = NaiveFixed(geometry, CONFIG).cast(record)
    return any((getattr(hits, field) != values).any() for field, values in vars(rule).items())


def test_without_a_fault_nothing_differs():
    assert not any(is_found(*case) for case in battery())


ICU = "golden.engine.icu."
FAULTS = {
    "vertices are truncated": (ICU + "g2r_transform", "round_shift(product, lost)", "product >> lost"),
    "vertex directions are truncated": (
        ICU + "vertex_direction", "shift(vertices, -exponent[..., None])",
        "(vertices << np.maximum(-exponent[..., None], 0)) >> np.maximum(exponent[..., None], 0)"),
    "the second triangle has another orientation": (ICU + "edge_planes", "winding[:, [0, 2]]", "winding[:, [0, 1]]"),
    "no patch is split": (ICU + "edge_planes", "~convex & ~is_triangle", "convex & ~convex"),
    "planes within one unit alone are dropped": (ICU + "plane_factor", "NEAREST_PLANE = 2", "NEAREST_PLANE = 1"),
    "m has no guard bits": (ICU + "plane_factor", "GUARD = 2", "GUARD = 0"),
    "the reciprocal is rounded up": (ICU + "reciprocal", "(1 << (2 * bits - 1)) //",
                                     "((1 << (2 * bits - 1)) + mantissa - 1) //"),
    "dropped patches are live": (ICU + "patch_setup", "live = ~factor.dropped & ~own", "live = ~own"),
    "1/t is rounded to nearest": (ICU + "inverse_distance", "(np.maximum(value, 1) >> down)",
                                  "((np.maximum(value, 1) + (1 << down >> 1)) >> down)"),
    "a ray that sees a patch edge-on misses it": (ICU + "inverse_distance", "SMALLEST = 1", "SMALLEST = 0"),
    "a ray on an edge misses": (ICU + "screening", "np.flatnonzero(least >= 0)", "np.flatnonzero(least > 0)"),
    "a split patch is its first triangle": (ICU + "screening", "planes.split & (second != 0)",
                                            "planes.split & (second > 1)"),
    "a cut of 0 is the right half": (ICU + "uv_subdivision", "left = cut >= 0", "left = cut > 0"),
    "of equal distances the larger id wins": (
        ICU + "ray_memory", "(_LAST_PATCH - patch)", "(patch + 1)",
        "_LAST_PATCH - (self._key & _LAST_PATCH)", "(self._key & _LAST_PATCH) - 1"),
    "an exponent has another bias": ("golden.engine.config.numbers", "- 1 - self.inverse_top", "- self.inverse_top"),
    "directions are truncated": ("golden.engine.frustum.record",
                                 "round_shift(sine[..., None] * self.column_table[column], "
                                 "self.numbers.direction_fraction)",
                                 "(sine[..., None] * self.column_table[column]) >> self.numbers.direction_fraction"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_setup_distance_or_screening_is_found(fault, monkeypatch):
    put(monkeypatch, *FAULTS[fault])
    assert any(is_found(*case) for case in battery())


CTU = "golden.engine.ctu."
TABLES = {
    "rotations of CORDIC": (
        "golden.engine.lib.cordic", "np.rint(np.arctan(", "np.floor(np.arctan(",
        partial(test_window_margins.test_rotations_and_gain_are_those_of_the_angles_of_powers_of_two, Icu())),
    "bound of an angle": (
        "golden.engine.lib.cordic", "+ 2 * cut", "+ cut",
        partial(test_window_margins.test_bounds_of_angles_and_quotients_are_their_derivations_rounded_up, Icu(), 17)),
    "sagittas": (
        ICU + "sbb", "np.ceil(sagitta", "np.floor(sagitta",
        partial(test_window_margins.test_sagittas_are_the_worst_of_their_box_rounded_up, (5, 6))),
    "slack of a polar angle": (
        ICU + "sbb", "2.0 ** (1 - config.numbers", "2.0 ** (-config.numbers",
        partial(test_window_margins.test_bounds_of_windows_are_their_derivations, Icu(), Numbers())),
    "reciprocals of cell steps": (
        CTU + "cell_traversal", "ends[:-1] - sag", "ends[:-1]",
        test_shared_tables.test_the_table_of_reciprocals_is_the_chord_lowered_by_half_its_sagitta),
    "settle codes": (
        ICU + "settle_code", "FIRST_EXPONENT = -1", "FIRST_EXPONENT = 0",
        partial(test_shared_tables.test_settle_codes_are_floats_from_a_half, Icu())),
    "weights": (
        "golden.cast.hemisphere", "np.rint(share", "np.floor(share",
        partial(test_shared_tables.test_weights_are_differences_of_the_rounded_integral, 64, 16, 32)),
    "directions of grid rays": (
        CTU + "grid_rays", "np.rint(values", "np.floor(values",
        partial(test_shared_tables.test_tables_of_grid_rays_are_the_nearest_integers, 5)),
    "slopes of grid rays": (
        CTU + "grid_rays", "(2 * np.arange(rays) + 1) / rays", "(2 * np.arange(rays)) / rays",
        partial(test_shared_tables.test_slopes_of_grid_rays_are_the_nearest_integers, 5)),
    "angle of a shell": (
        CTU + "margins", "DIAGONAL + RADIUS + slack", "DIAGONAL + slack",
        partial(test_margins.test_margins_are_their_derivations, 5)),
    "directions of rays": (
        "golden.engine.lib.fixed", "np.floor(np.abs(scaled) + 0.5)", "np.floor(np.abs(scaled))",
        partial(test_shared_tables.test_ray_tables_are_the_nearest_integers, 64, 16)),
    "slopes of pixels": (
        "golden.engine.frustum.record", "(2 * np.arange(size) + 1 - size)", "(2 * np.arange(size) - size)",
        partial(test_shared_tables.test_slopes_of_pixels_are_those_of_a_grid_of_powers_of_two, 24, 18)),
}


@pytest.mark.parametrize("fault", TABLES)
def test_a_fault_of_a_shared_table_is_found(fault, monkeypatch):
    *what, test = TABLES[fault]
    test()
    put(monkeypatch, *what)
    with pytest.raises(AssertionError):
        test()
