import numpy as np
import pytest

from golden.engine.config import Icu
from golden.engine.icu.screening import edge_distances, inside
from golden.engine.icu.uv_subdivision import align, uv_subdivision
from golden.engine.icu.vertex_direction import vertex_direction
from tb.golden.engine.icu.patches import CONFIG, setup

NUMBERS = CONFIG.numbers


def patches_in_front(seed, count, ratio):
    """Convex quads at z > 0, with vertices ``ratio`` times farther than others, and points on them."""
    random = np.random.default_rng(seed)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + random.uniform(-0.2, 0.2, (count, 4, 2))
    turn = np.linalg.qr(random.normal(size=(count, 3, 3)))[0][:, :2]
    flat = np.einsum("pci,pij->pcj", square - 0.5, turn) * random.uniform(0.05, 0.35, (count, 1, 1))
    where = np.stack([*random.uniform(-0.2, 0.2, (2, count)), random.uniform(0.4, 0.8, count)], axis=1)
    vertices = np.rint((flat + where[:, None]) / ratio * 2**22).astype(np.int64)
    return vertices, random.uniform(0.02, 0.98, (count, 2))


def bilinear(vertices, uv):
    p, (u, v) = vertices.astype(float), uv.T[:, :, None]
    return (1 - u) * (1 - v) * p[:, 0] + u * (1 - v) * p[:, 1] + u * v * p[:, 2] + (1 - u) * v * p[:, 3]


def aimed(vertices, uv):
    """Directions at bilinear points of the patches, orientations, edge distances, exponents."""
    point = bilinear(vertices, uv)
    direction = np.rint(point / np.linalg.norm(point, axis=1, keepdims=True) * 2**16).astype(np.int64)
    planes = setup(vertices)[1]
    distances = edge_distances(planes, direction, NUMBERS)
    return direction, inside(distances, planes)[1], distances, vertex_direction(vertices, NUMBERS)[1]


def subdivided(vertices, uv, icu):
    """(u, v) of rays through bilinear points of the patches; only of rays that hit and do not graze."""
    direction, orientation, distances, exponents = aimed(vertices, uv)
    p = vertices.astype(float)
    normal = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    steep = np.abs(np.einsum("pi,pi->p", normal, direction)) / np.linalg.norm(normal, axis=1) / 2**16
    good = np.flatnonzero(inside(distances, setup(vertices)[1])[0] & (steep > 0.3))
    return good, *uv_subdivision(align(distances, exponents, icu)[good], orientation[good], icu)


@pytest.mark.parametrize("icu", [Icu(), Icu(uv_bits=4), Icu(uv_bits=10, uv_guard=12)], ids=["8", "4", "10"])
@pytest.mark.parametrize("ratio", [1, 37, 1000])
def test_it_converges_to_the_bilinear_coordinates(ratio, icu):
    vertices, uv = patches_in_front(1, 3000, ratio)
    good, u, v = subdivided(vertices, uv, icu)
    assert len(good) > 1000
    # A step of the lattice, a unit of the direction seen from 0.4 to 0.8 on patches of 0.05 and more, and vertices in
    # whole units when the patch is small.
    allowed = 1 + 2.0**icu.uv_bits * (2.0**-11 + 8 * ratio * 2.0**-22 / 0.04)
    for steps, exact in ((u, uv[good, 0]), (v, uv[good, 1])):
        assert np.abs(steps + 0.5 - exact * 2**icu.uv_bits).max() <= allowed


def test_without_bits_the_patch_is_not_bisected():
    good, u, v = subdivided(*patches_in_front(1, 100, 1), Icu(uv_bits=0))
    assert len(good) > 30
    assert not u.any()
    assert not v.any()


def test_vertices_at_other_depths_need_the_alignment():
    floor = np.array([[[-8, -8, 16], [8, -8, 16], [64, -8, 240], [-64, -8, 240]]]) * 2**14
    u, v = (grid.ravel() for grid in np.meshgrid([0.2, 0.5, 0.8], [0.1, 0.3, 0.5]))
    uv, vertices = np.stack([u, v], axis=1), np.repeat(floor, 9, axis=0)
    _, orientation, distances, exponents = aimed(vertices, uv)
    assert (inside(distances, setup(vertices)[1])[0]).all()
    with_exponents, without = (uv_subdivision(align(distances, used, Icu()), orientation, Icu())
                               for used in (exponents, np.zeros_like(exponents)))
    assert max(np.abs(steps + 0.5 - exact * 256).max() for steps, exact in zip(with_exponents, (u, v), strict=True)) < 2
    assert max(np.abs(steps + 0.5 - exact * 256).max() for steps, exact in zip(without, (u, v), strict=True)) > 20


def test_corners_are_the_first_and_last_steps():
    vertices = np.array([[-9, -9, 40], [9, -9, 40], [9, 9, 40], [-9, 9, 40]])[None] * 2**14
    near = np.array([[0.001, 0.001], [0.999, 0.001], [0.999, 0.999], [0.001, 0.999]])
    _, u, v = subdivided(np.repeat(vertices, 4, axis=0), near, Icu())
    assert list(zip(u.tolist(), v.tolist(), strict=True)) == [(0, 0), (255, 0), (255, 255), (0, 255)]


def test_alignment_fills_the_width_and_keeps_the_ratios():
    random = np.random.default_rng(3)
    distances = random.integers(-(2**52), 2**52, (2000, 6)) >> random.integers(0, 40, (2000, 6))
    exponents = random.integers(-17, 7, (2000, 4))
    aligned = align(distances, exponents, Icu())
    largest = np.abs(aligned).max(axis=1)
    assert largest.min() >= 2**23
    assert largest.max() <= 2**24
    assert (align(np.zeros((3, 6), int), exponents[:3], Icu()) == 0).all()
