"""A ray visits the right voxels, tests each object once, and ends at the nearest hit, its light, or the right face."""

from fractions import Fraction

import numpy as np
import pytest

from radiosity.machines.torus.columns import Walk
from radiosity.machines.torus.grid_walk import (
    BLOCKED,
    EXIT,
    HIT,
    REACHED,
    walk,
)
from radiosity.machines.torus.node_boxes import node_boxes
from radiosity.machines.torus.node_grids import node_grids
from radiosity.machines.torus.object_tests import hit_distance
from radiosity.machines.torus.torus_scene import TorusScene
from tb.radiosity.machines.torus.torus_cases import drawn_scene

pytestmark = pytest.mark.usefixtures("interpreted")

SEEDS = range(40)


def prepared(scene, *, v, entries=0, growth=0.0):
    boxes = node_boxes(scene, side=1, size=(8, 8), growth=growth)
    return node_grids(scene.objects, scene.bounds, boxes, subdivisions=v, entries=entries), scene.objects


def walked(grids, objects, origin, direction, *, entry=0.0, limit=np.inf, mail=None, number=1):
    counts = np.zeros(len(Walk), dtype=np.int64)
    mail = np.zeros(len(objects.counts), dtype=np.int64) if mail is None else mail
    return (*walk(grids, objects, 0, origin, direction, entry, limit, mail, number, counts), counts)


def drawn_ray(rng, grids, v):
    origin = grids.low[0] + rng.uniform(0.05, 0.95, 3) * v * grids.cell[0]
    direction = rng.normal(size=3)
    if rng.random() < 0.3:
        direction[rng.integers(3)] = 0
    return origin, direction / np.linalg.norm(direction)


def exact_exit(grids, v, origin, direction):
    """Steps and face of a walk in rational arithmetic, y before x and both before z."""
    place, dist, delta = [], [], []
    for axis in range(3):
        low, size = Fraction(grids.low[0, axis]), Fraction(grids.cell[0, axis])
        start, slope = Fraction(origin[axis]), Fraction(direction[axis])
        place.append(int((start - low) // size))
        wall = low + (place[-1] + (slope > 0)) * size
        dist.append((wall - start) / slope if slope else None)
        delta.append(abs(size / slope) if slope else None)
    steps = 0
    while True:
        axis = min((one for one in (1, 0, 2) if dist[one] is not None), key=lambda one: dist[one])
        place[axis] += 1 if direction[axis] > 0 else -1
        dist[axis] += delta[axis]
        steps += 1
        if not 0 <= place[axis] < v:
            return steps, 2 * axis + (direction[axis] < 0), float(dist[axis] - delta[axis])


@pytest.mark.parametrize("entries", [0, 64])
@pytest.mark.parametrize("v", [1, 4, 13])
def test_steps_and_faces_are_those_of_rational_arithmetic(entries, v):
    # One small object at the far corner, which no drawn ray meets.
    grids, objects = prepared(drawn_scene(3, spheres=1, polygons=0), v=v, entries=entries)
    rng, faces = np.random.default_rng(v), set()
    far = objects._replace(corners=objects.corners + 1e6)
    for _ in range(300):
        origin, direction = drawn_ray(rng, grids, v)
        ended, face, distance, counts = walked(grids, far, origin, direction)
        steps, expected, leaves = exact_exit(grids, v, origin, direction)
        assert (ended, face, counts[Walk.STEPS]) == (EXIT, expected, steps)
        assert distance == pytest.approx(leaves)
        faces.add(face)
    assert len(faces) == 6


def test_equal_walls_are_crossed_y_first_then_x_then_z():
    grids, objects = prepared(drawn_scene(3, spheres=1, polygons=0), v=1)
    grids = grids._replace(low=np.zeros((1, 3)), cell=np.ones((1, 3)))
    far, diagonal = objects._replace(corners=objects.corners + 1e6), np.ones(3) / 3 ** 0.5
    for direction, face in ((diagonal, 2), (diagonal * (1, 0, 1), 0), (diagonal * (0, 1, 1), 2),
                            (-diagonal, 3), (diagonal * (0, 0, 1), 4)):
        assert walked(grids, far, np.full(3, 0.5), direction)[:2] == (EXIT, face)


@pytest.mark.parametrize("entries", [0, 16, 4096])
@pytest.mark.parametrize("v", [1, 3, 11])
def test_the_nearest_hit_is_that_of_all_tests_and_none_is_repeated(entries, v):
    rng, hits = np.random.default_rng(v), 0
    for seed in range(4):
        scene = drawn_scene(seed)
        grids, objects = prepared(scene, v=v, entries=entries)
        for _ in range(60):
            origin, direction = drawn_ray(rng, grids, v)
            distances = [hit_distance(objects, one, origin, direction) for one in range(len(scene))]
            ended, what, distance, counts = walked(grids, objects, origin, direction)
            if min(distances) < np.inf:
                hits += 1
                assert (ended, what, distance) == (HIT, int(np.argmin(distances)), min(distances))
            else:
                assert ended == EXIT
            assert counts[Walk.SPHERE_TESTS] + counts[Walk.POLYGON_TESTS] <= len(scene)
    assert hits > 20


@pytest.mark.parametrize("entries", [0, 256])
def test_shadow_rays_end_at_the_first_object_before_their_light_or_reach_it(entries):
    rng, ends = np.random.default_rng(2), []
    scene = drawn_scene(2)
    grids, objects = prepared(scene, v=6, entries=entries)
    for _ in range(200):
        origin, direction = drawn_ray(rng, grids, 6)
        limit = rng.uniform(0.05, 1.5)
        nearest = min(hit_distance(objects, one, origin, direction) for one in range(len(scene)))
        ended = walked(grids, objects, origin, direction, limit=limit)[0]
        assert (ended == BLOCKED) == (nearest < limit)
        ends.append(ended)
    assert {BLOCKED, REACHED} <= set(ends)


def polygons(*heights):
    """Squares across the z axis, each of its own half size."""
    corners = np.array([[(-size, -size, z), (size, -size, z), (size, size, z), (-size, size, z)]
                        for z, size in heights])
    count = len(heights)
    return TorusScene(name="squares", corners=corners, counts=np.full(count, 4), coefficients=np.zeros((count, 13)),
                      lights=np.zeros((0, 7)), slope=0.3)


def test_a_hit_in_a_later_voxel_waits_for_nearer_objects():
    """The slanted polygon is in the first voxel and is hit in the fourth; the square in the third one is nearer."""
    scene = polygons((1.0, 0.1), (3.0, 1.9), (5.0, 4.0))
    corners = scene.corners.copy()
    corners[0] = [(0.1, 0.1, 1.0), (1.9, 0.1, 1.0), (1.9, 1.9, 5.0), (0.1, 1.9, 5.0)]
    scene = TorusScene(name="slanted", corners=corners, counts=scene.counts, coefficients=scene.coefficients,
                       lights=scene.lights, slope=0.3)
    grids, objects = prepared(scene, v=4)
    origin, direction = np.array([1.0, 1.5, 0.5]), np.array([0.0, 0.0, 1.0])
    assert hit_distance(objects, 0, origin, direction) == pytest.approx(3.6111, abs=1e-4)
    assert walked(grids, objects, origin, direction)[:3] == (HIT, 1, 2.5)
    # Without the square the slanted polygon is hit, where it is.
    alone = objects._replace(corners=objects.corners + np.array([0, 1e6, 0])[:, None, None])
    assert walked(grids, alone, origin, direction)[1] == 0


def test_of_equal_hits_the_least_number_counts_wherever_it_is_in_a_list():
    for heights in (((2.0, 0.5), (2.0, 0.4), (3.0, 0.5)), ((3.0, 0.5), (2.0, 0.4), (2.0, 0.5))):
        grids, objects = prepared(polygons(*heights), v=3)
        found = walked(grids, objects, np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 1.0]))
        assert found[1] == min(number for number, (z, _) in enumerate(heights) if z == 2.0)


def test_objects_that_this_ray_has_been_tested_with_are_not_tested_again():
    scene = polygons((2.0, 0.5), (4.0, 0.5))
    grids, objects = prepared(scene, v=5)
    mail = np.array([7, 0])
    origin, direction = np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 1.0])
    assert walked(grids, objects, origin, direction, mail=mail.copy(), number=7)[1] == 1
    assert walked(grids, objects, origin, direction, mail=mail.copy(), number=8)[1] == 0


def test_a_walk_begins_where_the_ray_enters():
    scene = polygons((2.0, 0.5), (4.0, 0.5))
    grids, objects = prepared(scene, v=8)
    origin, direction = np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 1.0])
    counts = [walked(grids, objects, origin, direction, entry=entry)[3][Walk.STEPS] for entry in (2.0, 3.0)]
    assert walked(grids, objects, origin, direction, entry=3.0)[1] == 1
    assert counts[1] != counts[0]
