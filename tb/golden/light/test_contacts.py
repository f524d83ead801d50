"""Light beside bodies that stand on surfaces, against closed forms."""

import numpy as np
import pytest

from benchmarks.analytic import point_to_polygon
from golden.cast.grid import Grid
from golden.engine.cast.fixed_frusta import ShellingFrusta
from golden.light.final_gather import FinalGather
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.builtin.shapes import box, placed
from golden.scene.lights import PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of, solved

FLOOR = rectangle((0, 0, 0), (2, 0, 0), (0, 2, 0))
DISTANCES = np.array([0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2])
OPEN = (1.0, 1.0, 1.0)


def tolerance(distance):
    """15 % from 2 mm on, 5 % from 1 cm on."""
    return np.where(distance < 0.01, 0.15, 0.05)


def column(radius, height, sides=16):
    """A prism without bases around the floor's middle."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.stack([1 + radius * np.cos(angle), 1 + radius * np.sin(angle), 0 * angle], axis=1)
    top = ring + np.array([0, 0, height])
    return np.stack([ring[:-1], ring[1:], top[1:], top[:-1]], axis=1)


def lit(scene, points, samples=256, max_edge=0.17, **options):
    """Indirect light at points of the floor, patch 0; options of `FinalGather`."""
    caster, tally, indirect = Grid(scene), Tally(), solved(scene, max_edge)
    count = len(points)
    surface = SurfacePoints(points, np.tile((0.0, 0, 1), (count, 1)), np.zeros(count, dtype=int))
    return FinalGather(scene, indirect, caster, tally, samples, **options).light(
        surface, points[:, 0] / 2, points[:, 1] / 2, np.ones(count, dtype=bool), np.full(count, mix(0, 7)),
        np.arange(count))[:, 0]


def open_sky(points, faces):
    """Share of a uniform sky that points of the floor see past a convex body: the faces turned to them hide it."""
    hidden = point_to_polygon(points, np.tile((0.0, 0, 1), (len(points), 1)), faces)
    return 1 - np.maximum(hidden, 0).sum(axis=1)


BLOCK = box((0.53, 0.71, 0), (1.33, 1.42, 0.4), omit=("-z",))
# From the column's middle to that of a face.
FACE = np.array([np.cos(np.pi / 16), np.sin(np.pi / 16), 0])
# Bodies, and the point of the floor from which distances count, and the direction away from the body.
BODIES = {
    "box": (BLOCK, (1.0, 0.71, 0), (0, -1, 0)),
    "box, other side": (BLOCK, (1.33, 1.0, 0), (1, 0, 0)),
    "turned box with a bottom": (placed(box((-0.3, -0.2, 0), (0.3, 0.2, 0.5)), at=(1.02, 0.97, 0), turn=30),
                                 (1.12, 0.97 - 0.2 / np.cos(np.pi / 6) + 0.1 * np.tan(np.pi / 6), 0),
                                 (0.5, -np.sqrt(0.75), 0)),
    "step": (box((0, 0.91, 0), (2, 2, 0.15), omit=("-z",)), (1.0, 0.91, 0), (0, -1, 0)),
    "slab of 2 cm": (box((0.3, 0.91, 0), (1.7, 1.5, 0.02), omit=("-z",)), (1.0, 0.91, 0), (0, -1, 0)),
    "column": (column(0.15, 1.5), 1 + 0.15 * FACE[0] * FACE - (0, 0, 1), FACE),
    "leg": (box((0.97, 1.01, 0), (1.02, 1.06, 0.7), omit=("-z",)), (1.0, 1.01, 0), (0, -1, 0)),
    "shelf": (box((0.3, 0.91, 0), (1.7, 0.93, 0.3), omit=("-z",)), (1.0, 0.91, 0), (0, -1, 0)),
    "shelf, other side": (box((0.3, 0.91, 0), (1.7, 0.93, 0.3), omit=("-z",)), (1.0, 0.93, 0), (0, 1, 0)),
    "bed on legs": (box((0.4, 0.83, 0.1), (1.6, 1.7, 0.4)), (1.0, 0.83, 0), (0, -1, 0)),
}


@pytest.mark.parametrize("name", ["box", "turned box with a bottom", "column", "shelf", "bed on legs", *(
    pytest.param(name, marks=pytest.mark.nightly) for name in (
        "box, other side", "step", "slab of 2 cm", "leg", "shelf, other side"))])
def test_the_sky_beside_a_black_body_is_the_closed_form(name):
    faces, start, away = BODIES[name]
    points = np.array(start) + DISTANCES[:, None] * np.array(away)
    truth = open_sky(points, faces)
    found = lit(scene_of((FLOOR, BLACK), (faces, BLACK), background=OPEN), points)
    assert (np.abs(found / truth - 1) < tolerance(DISTANCES)).all(), found / truth - 1


@pytest.mark.parametrize("name", ["box", "shelf"])
def test_hemispheres_of_frusta_gather_the_sky_beside_a_black_body(name):
    faces, start, away = BODIES[name]
    points, scene = np.array(start) + DISTANCES[:, None] * np.array(away), scene_of(
        (FLOOR, BLACK), (faces, BLACK), background=OPEN)
    found = lit(scene, points, frusta=ShellingFrusta(scene), together=1)
    assert (np.abs(found / open_sky(points, faces) - 1) < tolerance(DISTANCES)).all()


def test_points_of_a_pixel_on_one_side_of_a_patch_share_a_hemisphere():
    faces, start, away = BODIES["box"]
    points, scene = np.array(start) + np.linspace(0.01, 0.04, 8)[:, None] * np.array(away), scene_of(
        (FLOOR, BLACK), (faces, BLACK), background=OPEN)
    each, of_four, of_eight = (lit(scene, points, frusta=ShellingFrusta(scene), together=together)
                               for together in (1, 4, 8))
    assert each[0] != each[4]
    np.testing.assert_array_equal(of_four, each[[0, 0, 0, 0, 4, 4, 4, 4]])
    np.testing.assert_array_equal(of_eight, each[0])


# A room of 2 x 2 x 1 whose ceiling alone reflects, and a point light on one side of a partition.
CEILING, LIGHT, REFLECTANCE = rectangle((0, 0, 1), (0, 2, 0), (2, 0, 0)), np.array((0.4, 1.1, 0.2)), 0.6
PARTITION = 1.07
# The largest element that a render chooses in it.
DEFAULT = np.sqrt(16 / 3000)


def reflected_by_ceiling(points, free, fields=400):
    """Brute force: a sum over fields of the ceiling of what they reflect to points of the floor.

    ``free(a, b)``: whether lines from points a to points b pass the partition.
    """
    middle = (np.arange(fields) + 0.5) * 2 / fields
    y = np.stack([*(grid.ravel() for grid in np.meshgrid(middle, middle)), np.ones(fields**2)], axis=1)
    distance2 = ((y - LIGHT) ** 2).sum(axis=1)
    bright = REFLECTANCE / np.pi * (1 - LIGHT[2]) / distance2**1.5 * free(LIGHT, y)
    return np.array([(bright / (np.pi * ((y - x) ** 2).sum(axis=1) ** 2) * free(x, y)).sum() for x in points]) * (
        2 / fields) ** 2


def passes_partition(low, high, top):
    """`reflected_by_ceiling`'s ``free`` of a partition at x = `PARTITION` from y = ``low`` to ``high``."""

    def free(a, b):
        share = (PARTITION - a[0]) / (b[:, 0] - a[0])
        y, z = a[1] + share * (b[:, 1] - a[1]), a[2] + share * (b[:, 2] - a[2])
        return ~((share > 0) & (share < 1) & (y > low) & (y < high) & (z < top))

    return free


@pytest.mark.parametrize(("low", "high", "top", "max_edge"), [
    (0, 2, 0.5, 0.17), *(pytest.param(*case, DEFAULT, marks=pytest.mark.nightly)
                         for case in ((0, 2, 0.5), (0.5, 1.5, 0.8), (0.8, 2, 1)))],
    ids=["low partition, coarse", "low partition", "partition", "door ajar"])
def test_lamp_light_beside_a_thin_partition_is_what_brute_force_gathers(low, high, top, max_edge):
    walls = box((0, 0, 0), (2, 2, 1), omit=("-z", "+z"))[:, ::-1]
    sheet = rectangle((PARTITION, low, 0), (0, high - low, 0), (0, 0, top))
    scene = scene_of((FLOOR, BLACK), (CEILING, Material(name="white", diffuse=(REFLECTANCE,) * 3)), (walls, BLACK),
                     (sheet, BLACK, {"two_sided": True}), lights=(PointLight(position=LIGHT, intensity=(1, 1, 1)),))
    points = np.stack([np.concatenate([PARTITION - DISTANCES, PARTITION + DISTANCES]), np.full(14, 1.17),
                       np.zeros(14)], axis=1)
    truth = reflected_by_ceiling(points, passes_partition(low, high, top))
    found = lit(scene, points, samples=4096, max_edge=max_edge)
    assert (np.abs(found / truth - 1) < tolerance(np.tile(DISTANCES, 2))).all(), found / truth - 1


@pytest.mark.parametrize("thickness", [0.0, 0.02])
@pytest.mark.parametrize("begin", [PARTITION, 1.0], ids=["across elements", "on a line of them"])
def test_no_light_leaks_through_a_thin_wall_into_a_sealed_room(begin, thickness):
    """Though elements of the floor, the ceiling and the long walls are on both sides of it, or share nodes in it."""
    grey, end = Material(name="grey", diffuse=(0.6,) * 3), begin + thickness
    wall = box((begin, 0, 0), (end, 2, 1)) if thickness else rectangle((begin, 0, 0), (0, 2, 0), (0, 0, 1))
    scene = scene_of((box((0, 0, 0), (2, 2, 1))[:, ::-1], grey), (wall, grey, {"two_sided": not thickness}),
                     lights=(PointLight(position=LIGHT, intensity=(1, 1, 1)),))
    light = solved(scene)
    x = light.elements.centre[:, 0]
    assert 1.0 in light.elements.lattice.position[:, 0].round(9)
    assert light.received[x < begin - 0.1].min() > 0
    assert light.received[x > end + 0.05].max() == 0
