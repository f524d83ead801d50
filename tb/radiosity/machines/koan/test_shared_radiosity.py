"""Form factors and radiosities that travel in pages are golden's, byte for byte."""

from contextlib import nullcontext
from functools import cache

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.light.solvers import gauss_jacobi
from golden.scene.builtin import builtin_scene
from radiosity.machines.koan.koan_machine import KoanRadiosity, koan_cell
from radiosity.machines.koan.ray_pages import ray_pages
from radiosity.machines.koan.scene_pages import ScenePages
from tb.radiosity.machines.gather.nodes import room

PATCHES = 60


@cache
def solved(nodes, frames):
    return machine().run(nodes=nodes, frames=frames)


@cache
def machine():
    return KoanRadiosity(room(PATCHES)[0], rays=(16, 8), cell=1 / 6, page_bytes=512)


@pytest.mark.parametrize(("nodes", "frames"), [(1, 1), (2, 4), (4, 64), (8, 3), (16, 64)])
def test_form_factors_and_radiosities_have_golden_s_bytes(nodes, frames):
    _, system, _ = room(PATCHES)
    found, golden = solved(nodes, frames), gauss_jacobi(system)
    for name in ("data", "indices", "indptr"):
        assert np.array_equal(getattr(found.factors, name), getattr(system.matrix, name))
    assert found.solution.radiosity.tobytes() == golden.radiosity.tobytes()
    assert found.solution.steps == golden.steps


def test_a_step_invalidates_the_copies_of_radiosities_and_one_node_has_none():
    alone, report = solved(1, 1).report(), solved(4, 64).report()
    assert alone["solution"]["invalidations"] == alone["solution"]["fetches"] == 0
    # 180 radiosities are in 3 pages, whose writers take them from the 3 other nodes in each step but the first.
    assert report["solution"]["invalidations"] >= 3 * (report["steps"] - 1)
    assert report["solution"]["recalls"] > 0


def test_rows_that_share_a_page_pass_it_between_their_nodes():
    report = solved(16, 64).report()
    assert report["form_factors"]["invalidations"] > 0


def test_pages_being_written_go_home_from_a_small_cache():
    small, large = solved(8, 3).report(), solved(16, 64).report()
    assert small["form_factors"]["write_backs"] > 0
    assert large["form_factors"]["write_backs"] == 0
    assert (small["F"], small["radiosity"]) == (large["F"], large["radiosity"])


def test_neighbouring_directions_refer_to_fewer_pages_than_directions_in_disorder():
    """Faults of the rays of a hemisphere, one by one, in a cache that holds the pages of a ray, not those of all."""
    scene = builtin_scene("teapot:3")
    grid, hemisphere = Grid(scene, koan_cell(scene), jobs=1), Hemisphere(32, 16)
    layout, count = ScenePages.of(grid.cells, len(scene), 256), len(hemisphere)
    faults = []
    for order in (np.arange(count), np.random.default_rng(1).permutation(count)):
        directions = hemisphere.directions[order] @ frame(scene.normals[:1])[0]
        rays = Rays(np.repeat(scene.centres[:1], count, axis=0), directions, source=np.full(count, scene.surface[0]))
        string = ray_pages(grid.cells, layout, rays, grid.nearest(rays), np.arange(count), count, frames=128)
        cache = Cache(CachePolicy.LRU, lines=128, ways=128)
        cache.access(string.page)
        faults.append(cache.misses)
    assert 1.3 * faults[0] < faults[1]


def test_more_nodes_make_form_factors_faster():
    assert solved(4, 64).rows < 0.5 * solved(1, 1).rows


def test_a_solution_that_is_not_reached_is_an_error(monkeypatch):
    """Of as many steps as it takes, and one less."""
    steps = solved(2, 4).solution.steps
    for most in steps, steps - 1:
        monkeypatch.setattr("radiosity.machines.koan.shared_radiosity._MOST_STEPS", most)
        with nullcontext() if most == steps else pytest.raises(
                InputError, match=f"Steps must be more than {most} for an error below"):
            machine().run(nodes=2, frames=4)
