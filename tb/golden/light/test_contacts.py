"""Light beside bodies that stand on surfaces, against closed forms."""

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.frustum import Hemisphere
from golden.light.analytic import point_to_polygon
from golden.light.final_gather import FinalGather
from golden.light.indirect import indirect_light
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.builtin.shapes import box, placed
from golden.scene.refine import refine
from tb.golden.light.scenes import BLACK, rectangle, scene_of

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


def lit(scene, points, samples=256, max_edge=0.17):
    """Indirect light at points of the floor, patch 0."""
    caster, tally = Grid(scene), Tally()
    indirect = indirect_light(scene, refine(scene, max_edge=max_edge), caster, caster, tally,
                              hemisphere=Hemisphere(64, 16), solver="conjugate-gradient", light_samples=16, seed=0)
    count = len(points)
    surface = SurfacePoints(points, np.tile((0.0, 0, 1), (count, 1)), np.zeros(count, dtype=int))
    return FinalGather(scene, indirect, caster, tally, samples).light(
        surface, points[:, 0] / 2, points[:, 1] / 2, np.ones(count, dtype=bool), mix(0, 7, np.arange(count)),
        np.zeros(count, dtype=int), 1)[:, 0]


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
    "bed on legs": (box((0.4, 0.83, 0.1), (1.6, 1.7, 0.4)), (1.0, 0.83, 0), (0, -1, 0)),
}


@pytest.mark.parametrize("name", BODIES)
def test_the_sky_beside_a_black_body_is_the_closed_form(name):
    faces, start, away = BODIES[name]
    points = np.array(start) + DISTANCES[:, None] * np.array(away)
    truth = open_sky(points, faces)
    found = lit(scene_of((FLOOR, BLACK), (faces, BLACK), background=OPEN), points)
    assert (np.abs(found / truth - 1) < tolerance(DISTANCES)).all(), found / truth - 1
