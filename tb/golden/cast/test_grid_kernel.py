"""The grid has the bits of brute force, and the counts of a walk in Python, at any offset and scale."""

import dataclasses

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.material import Material
from tb.golden.cast.cell_walk import cell_walk
from tb.golden.scene.touched_cells import touched_cells
from tb.golden.soups import axis_rays, closed_mesh, random_rays, soup

FIELDS = ("patch", "t", "u", "v", "tests", "steps")
# Offsets in sizes of the scene, and scales.
PLACES = ((0, 1), (1e3, 1), (-3e6, 1), (2e8, 1), (0.3, 1e-50), (-7, 1e50), (0, 2.0**-199), (0, 2.0**198))


def assert_bits(found, expected, fields=FIELDS):
    for name in fields:
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes(), name


def placed(scene, offset, scale):
    """A scene elsewhere and of another size."""
    return dataclasses.replace(scene, vertices=(scene.vertices + offset * scene.size) * scale)


def rays_into(scene, seed):
    """Random rays, some that end, some from surfaces, and rays along the axes through vertices."""
    random, plain, axial = np.random.default_rng(seed), random_rays(scene, seed, 600), axis_rays(scene, seed, 600)
    origin = np.concatenate([plain.origin, axial.origin])
    direction = np.concatenate([plain.direction, axial.direction * scene.size])
    return Rays(origin, direction, source=random.integers(-1, scene.surface.max() + 1, len(origin)),
                tmax=random.choice([0.0, 0.5, 1.0, np.inf], len(origin)),
                target=random.integers(-1, scene.surface.max() + 1, len(origin)))


@pytest.mark.parametrize(("offset", "scale"), PLACES)
def test_the_bits_are_those_of_naive_wherever_the_scene_is(offset, scale):
    scene = placed(soup(4), offset, scale)
    rays = rays_into(scene, 4)
    expected = Naive(scene).nearest(rays)
    assert (expected.patch >= 0).sum() > 100
    grid = Grid(scene, 0.11)
    found = grid.nearest(rays)
    assert_bits(found, cell_walk(grid, rays))
    assert_bits(found, expected, FIELDS[:4])
    assert_bits(grid.any_hit(rays), cell_walk(grid, rays, any_hit=True))


@pytest.mark.parametrize("name", ["box", "icosphere"])
def test_degenerate_rays(name):
    scene = closed_mesh(name)
    rays = axis_rays(scene, 5, 2000)
    # In the planes of patches, and with components that differ by hundreds of orders.
    rays = Rays(rays.origin, rays.direction + np.array([1e-200, 0, 1e-320]) * scene.size)
    grid = Grid(scene, 0.07)
    found = grid.nearest(rays)
    assert_bits(found, cell_walk(grid, rays))
    assert_bits(found, Naive(scene).nearest(rays), FIELDS[:4])


def test_the_bits_are_those_of_naive_at_ties_ends_and_borders_of_cells():
    """Every coordinate is a multiple of a half, as are borders of cells; patches lie on them, two at each place."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    places = np.array([(x, y, z) for x in range(4) for y in range(4) for z in range(5) if (x + 2 * y + z) % 3])
    squares = corners + places[:, None]
    squares = np.where((places[:, 0] % 2 > 0)[:, None, None], squares, squares[:, :, [2, 0, 1]])
    builder = SceneBuilder("lattice")
    for _ in range(2):
        builder.add(squares, Material(name="paint"))
    scene, random = builder.build(), np.random.default_rng(4)
    direction = random.integers(-1, 2, (3000, 3)) * random.choice([0.5, 1.0], (3000, 1))
    direction[~direction.any(axis=1)] = (0, 0, 1)
    # Hits are at multiples of a half.
    tmax = random.choice([0, 1, np.nextafter(1, 0), np.nextafter(1, 2), 2, np.inf], 3000)
    rays = Rays(random.integers(-1, 10, (3000, 3)) / 2, direction, tmax=tmax)
    expected = Naive(scene).nearest(rays)
    assert (expected.t[tmax == np.nextafter(1, 2)] == 1).sum() > 20
    assert (expected.patch >= 0).sum() > 300
    for cell in (0.125, 0.25, 1.0):
        grid = Grid(scene, cell)
        found, cells = grid.nearest(rays), grid.cells
        assert_bits(found, cell_walk(grid, rays))
        assert_bits(grid.any_hit(rays), cell_walk(grid, rays, any_hit=True))
        assert_bits(found, expected, FIELDS[:4])
        start, patch = touched_cells(scene.vertices - cells.base, lower=-cells.margin, size=cells.size,
                                     shape=cells.shape, margin=cells.margin)
        np.testing.assert_array_equal(cells.start, start)
        np.testing.assert_array_equal(cells.patch, patch)


def test_no_rays_have_no_hits():
    hits = Grid(soup(4), 0.11).nearest(Rays(np.zeros((0, 3)), np.zeros((0, 3))))
    assert [len(getattr(hits, name)) for name in FIELDS] == [0] * 6


@pytest.mark.parametrize("offset", [0, 3e6])
def test_occlusion_of_segments_is_that_of_brute_force(offset):
    scene = placed(soup(2), offset, 1)
    random = np.random.default_rng(2)
    patches = random.integers(len(scene), size=(2000, 2))
    ends = scene.centres[patches]
    ends[:50, 1] = ends[:50, 0]
    skip = scene.surface[patches].astype(np.int32)
    skip[1000:1200] = -1
    expected = Naive(scene).occluded(ends[:, 0], ends[:, 1], skip)
    assert not expected[:50].any()
    assert 200 < expected.sum() < 1800
    grid = Grid(scene)
    np.testing.assert_array_equal(grid.occluded(ends[:, 0], ends[:, 1], skip), expected)
    # A segment is as occluded as its reverse.
    assert (grid.occluded(ends[:, 1], ends[:, 0], skip[:, ::-1]) != expected).sum() <= 2


@pytest.mark.parametrize("caster", [Naive, Grid])
def test_scenes_and_rays_that_float64_does_not_resolve(caster):
    scene = builtin_scene("cornell")
    with pytest.raises(InputError, match=r"Coordinates must be at most .* times its size .*; move it to the origin"):
        caster(placed(scene, 3e8, 1))
    with pytest.raises(InputError, match=r"Size must be .*, not"):
        caster(dataclasses.replace(scene, vertices=scene.vertices * (2.0**-250)))
    with pytest.raises(InputError, match="rays: Origin of ray 1 must be within 262144 of the scene's size"):
        caster(scene).nearest(Rays([[0, 0, 0], [1e9, 0, 0]], [[1, 0, 0], [1, 0, 0]]))
    with pytest.raises(InputError, match=r"rays: Direction of ray 0 must be .* long, not"):
        caster(scene).nearest(Rays([[0, 0, 0]], [[1e-200, 0, 0]]))


@pytest.mark.parametrize("shapes", [((2, 3), (3, 3), (2, 2)), ((2, 3), (2, 3), (2,)), ((2, 3), (2, 3), (1, 2))])
def test_segments_of_the_wrong_shape(shapes):
    with pytest.raises(InputError, match="segments: Origins, targets and skip must be R x 3, R x 3 and R x 2, not"):
        Naive(builtin_scene("cornell")).occluded(*(np.zeros(shape) for shape in shapes))
