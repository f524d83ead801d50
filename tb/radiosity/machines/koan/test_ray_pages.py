"""Rays refer to the pages of the cells, lists and patches that the grid's cast meets."""

from collections import OrderedDict
from functools import cache

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.scene.builtin import builtin_scene
from radiosity.machines.koan.pixel_rays import pixel_rays
from radiosity.machines.koan.ray_pages import ray_pages
from radiosity.machines.koan.ray_work import ray_work
from radiosity.machines.koan.scene_pages import ScenePages

SIZE = (16, 12)


@cache
def traced(name):
    scene = builtin_scene(name)
    grid = Grid(scene, 1 / 8, jobs=1)
    return scene, grid, pixel_rays(scene, grid, size=SIZE)


@cache
def string(name, page_bytes, frames=1 << 20):
    scene, grid, made = traced(name)
    layout = ScenePages.of(grid.cells, len(scene), page_bytes)
    return layout, ray_pages(grid.cells, layout, made.rays, made.hits, made.pixel, SIZE[0] * SIZE[1], frames=frames)


def faults(pages, frames):
    held, count = OrderedDict(), 0
    for page in pages:
        count += page not in held
        if page not in held and len(held) == frames:
            held.popitem(last=False)
        held[page] = True
        held.move_to_end(page)
    return count


@pytest.mark.parametrize("name", ["cornell", "teapot", "mountain"])
def test_references_are_those_of_the_grid_s_steps_and_tests(name):
    _, _, made = traced(name)
    expected = np.bincount(made.pixel, made.hits.steps + 2 * made.hits.tests, SIZE[0] * SIZE[1])
    assert np.array_equal(string(name, 1024)[1].touches, expected)


def test_a_pixel_s_pages_are_those_of_its_cells_lists_and_patches():
    """All cells along rays, found by points every 1/200 of a cell."""
    scene, grid, made = traced("teapot")
    layout, found = string("teapot", 256)
    cells, first, sizes = grid.cells, layout.first, []
    for pixel in range(40, 140, 7):
        pages = set()
        for ray in np.flatnonzero(made.pixel == pixel):
            end = made.hits.t[ray] if made.hits.patch[ray] >= 0 else min(made.rays.tmax[ray], 1e3)
            length = np.linalg.norm(made.rays.direction[ray])
            along = np.arange(0, min(end, 3 * scene.size / length), cells.size / 200 / length)
            index = ((made.rays.origin[ray] + along[:, None] * made.rays.direction[ray] - cells.base + cells.margin)
                     // cells.size).astype(int)
            index = index[((index >= 0) & (index < cells.shape)).all(axis=1)]
            for cell in np.unique(np.ravel_multi_index(index.T, cells.shape)):
                pages.add(first[0] + cell * 8 // 256)
                for entry in range(cells.start[cell], cells.start[cell + 1]):
                    pages |= {first[1] + entry * 4 // 256, first[2] + cells.patch[entry] * 128 // 256}
        listed = set(found.page[found.first[pixel]:found.first[pixel + 1]].tolist())
        assert pages <= listed
        assert len(listed) == found.distinct[pixel]
        sizes.append((len(pages), len(listed)))
    # Points miss the corners of cells.
    assert np.sum(sizes, axis=0)[1] <= 1.03 * np.sum(sizes, axis=0)[0]


@pytest.mark.parametrize("share", [0, 1 / 16, 1 / 4, 1 / 2, 1, 2])
def test_a_cache_of_any_frames_has_the_faults_of_all_references(share):
    """Of frames for a share of the pages of the pixel that has most of them."""
    _, grid, made = traced("teapot")
    layout, shortest = string("teapot", 256)
    frames = max(1, int(share * shortest.distinct.max()))
    found = string("teapot", 256, frames)[1]
    # A group for each ray, all of whose references are listed.
    each = ray_pages(grid.cells, layout, made.rays, made.hits, np.arange(len(made.pixel)), len(made.pixel), frames=0)
    assert faults(found.page.tolist(), frames) == faults(each.page.tolist(), frames) > 0
    assert np.array_equal(found.distinct, shortest.distinct)
    assert (len(found.page) == len(shortest.page)) == (share >= 1)
    assert len(each.page) > len(shortest.page)


def test_regions_are_of_whole_pages():
    layout = ScenePages(cells=100, entries=300, patches=20, page_bytes=512)
    assert layout.first.tolist() == [0, 2, 5, 10]
    assert (len(layout), layout.size) == (10, 800 + 1200 + 2560)


@pytest.mark.parametrize("page_bytes", [64, 1000, 0])
def test_pages_of_other_sizes_are_refused(page_bytes):
    with pytest.raises(InputError, match="Page bytes must be a power of two from 128"):
        ScenePages(cells=1, entries=1, patches=1, page_bytes=page_bytes)


def test_work_is_that_of_rays_cells_and_tests():
    _, _, made = traced("cornell")
    work = ray_work(made.hits, made.pixel, SIZE[0] * SIZE[1])
    assert work.sum() == 587_000 * len(made.pixel) + 46_960 * made.hits.steps.sum() + 176_100 * made.hits.tests.sum()
    assert work.min() >= 587_000
