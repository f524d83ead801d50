"""The grid's hits are bit-exact with brute force in float64."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.scene.builtin import builtin_scene
from tb.golden.soups import axis_rays, closed_mesh, random_rays, soup

CELLS = (None, 1.0, 0.5, 0.125, 0.03)


def assert_same(scene, rays, cell):
    naive, grid = Naive(scene).nearest(rays), Grid(scene, cell).nearest(rays)
    for name in ("patch", "t", "u", "v"):
        np.testing.assert_array_equal(getattr(grid, name), getattr(naive, name), err_msg=name)
    return grid


@pytest.mark.parametrize(("seed", "cell"), list(enumerate(CELLS)))
def test_random_rays_in_a_soup_hit_what_naive_hits(seed, cell):
    scene = soup(seed)
    hits = assert_same(scene, random_rays(scene, seed, 3000), cell)
    assert (hits.patch >= 0).sum() > 300


@pytest.mark.parametrize(("name", "cell"), list(zip(["box", "icosphere"] * 3, CELLS, strict=False)))
def test_axis_parallel_rays_through_vertices_and_cell_corners_hit_what_naive_hits(name, cell):
    scene = closed_mesh(name)
    assert_same(scene, axis_rays(scene, 3, 3000), cell)


def test_equally_near_patches_give_the_smaller_number():
    scene = soup(0)
    duplicates = {number: duplicate for number in range(len(scene)) for duplicate in range(number)
             if np.array_equal(scene.vertices[number], scene.vertices[duplicate])}
    assert len(duplicates) >= 2
    targets = scene.vertices[list(duplicates)].mean(axis=1)
    origin = targets + 1e-3 * scene.normals[list(duplicates)]
    for caster in (Naive(scene), Grid(scene)):
        hits = caster.nearest(Rays(origin, targets - origin))
        assert not set(hits.patch.tolist()) & set(duplicates)


@pytest.mark.parametrize("fewest", [1 << 6, 1 << 12])
def test_hits_do_not_depend_on_threads_and_their_shares(monkeypatch, fewest):
    scene = builtin_scene("lobby")
    rays = random_rays(scene, 4, 5000)
    whole = Grid(scene, jobs=1).nearest(rays)
    monkeypatch.setattr("golden.cast.grid.FEWEST", fewest)
    hits = Grid(scene, jobs=3).nearest(rays)
    for name in ("patch", "t", "u", "v", "tests", "steps"):
        np.testing.assert_array_equal(getattr(hits, name), getattr(whole, name), err_msg=name)


@pytest.mark.parametrize("jobs", [0, -1, 257])
def test_jobs_out_of_range(jobs):
    with pytest.raises(InputError, match=f"Jobs must be 1 to 256, not {jobs}"):
        Grid(builtin_scene("cornell"), jobs=jobs)


def test_steps_are_the_cells_that_a_ray_passes():
    scene = closed_mesh("box")
    grid = Grid(scene, 0.125)
    # Along x through the middle of a row of cells, from outside: the hit is in the first cell already; from the centre
    # it goes through half of them.
    rays = Rays([[-2, 0.03, 0.03], [0.03, 0.03, 0.03]], [[1, 0, 0], [1, 0, 0]])
    assert grid.nearest(rays).steps.tolist() == [1, int(grid.cells.shape[0]) - int(0.53 / 0.125)]


@pytest.mark.parametrize("cell", [0, -1, 2, 1e-3, np.nan])
def test_cell_size_out_of_range(cell):
    with pytest.raises(InputError, match="Cell size must be 1/256 to 1 of the scene's longest side, not"):
        Grid(builtin_scene("cornell"), cell)
