"""The picture has the bytes of one node's, and every pixel is an item's of one node."""

from functools import cache

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from radiosity.machines.koan.koan_machine import KoanMachine
from radiosity.machines.koan.page_timing import PageTiming
from radiosity.machines.koan.pixel_items import SCHEDULES, pixel_items, tile_shape

SIZE = (40, 36)


@cache
def machine():
    return KoanMachine(builtin_scene("teapot"), size=SIZE)


@pytest.mark.parametrize("nodes", [1, 2, 4, 16, 64])
@pytest.mark.parametrize("schedule", SCHEDULES)
def test_pictures_have_the_bytes_of_one_node_s(schedule, nodes):
    found = machine().run(nodes=nodes, schedule=schedule, frames=16, page_bytes=1024)
    assert found.picture.tobytes() == machine().traced.picture.tobytes()
    assert found.report()["picture"] == machine().run(nodes=1).report()["picture"]


def test_pictures_do_not_depend_on_pages_caches_items_and_timing():
    for options in ({"page_bytes": 256}, {"frames": 1}, {"side": 1}, {"side": 16},
                    {"timing": PageTiming(serve=0, trap=0)}):
        assert machine().run(nodes=8, **options).picture.tobytes() == machine().traced.picture.tobytes()


def test_an_item_has_3_x_3_pixels_and_a_cache_2_mib_of_pages_of_4_kib():
    report = machine().run(nodes=1).report()
    assert report["items"] == 14 * 12
    assert (report["page_bytes"], report["page_bytes"] * report["frames"]) == (4096, 2 << 20)


def test_one_node_has_all_pages_and_takes_the_time_alone():
    found = machine().run(nodes=1)
    assert found.time == found.work
    assert found.efficiency == 1
    assert found.state.counted["faults"].sum() == found.state.cube.sent.sum() == 0


def test_work_is_scaled_to_the_seconds_that_are_known():
    assert machine().run(nodes=1, alone=10.0).time == pytest.approx(10e9, abs=SIZE[0] * SIZE[1])


def test_each_node_fetches_a_page_of_another_home_once_if_all_fit():
    found = machine().run(nodes=4, page_bytes=1024, frames=4096, log=100_000)
    log = found.state.log[:found.state.logged[0]]
    assert len(log) == len(np.unique(log[:, 1:3], axis=0)) == found.state.counted["fetches"].sum()
    assert found.state.counted["drops"].sum() == found.state.counted["invalidations"].sum() == 0
    assert (log[:, 1] != log[:, 2] % 4).all()


def test_a_smaller_cache_has_more_faults_and_takes_longer():
    runs = [machine().run(nodes=4, page_bytes=1024, frames=frames) for frames in (8, 32, 128, 512)]
    counts = [one.state.counted["faults"].sum() for one in runs]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 4 * counts[-1]
    assert runs[0].time > runs[-1].time


@pytest.mark.parametrize(("nodes", "size", "shape"), [
    (4, (512, 512), (2, 2)), (8, (512, 512), (2, 4)), (32, (512, 512), (4, 8)), (2, (100, 50), (2, 1)),
    (1, (9, 9), (1, 1))])
def test_tiles_are_nearly_square(nodes, size, shape):
    assert tile_shape(nodes, size) == shape


@pytest.mark.parametrize("schedule", SCHEDULES)
@pytest.mark.parametrize("side", [1, 3, 5])
def test_items_are_squares_that_cover_the_picture_once(schedule, side):
    items = pixel_items((26, 19), 8, side=side, schedule=schedule)
    assert sorted(items.pixel) == list(range(26 * 19))
    assert items.own[-1] == len(items.first) - 1
    assert np.diff(items.first).max() == side * side
    for begin, end in zip(items.first, items.first[1:], strict=False):
        row, column = np.divmod(items.pixel[begin:end], 26)
        assert np.ptp(row) < side
        assert np.ptp(column) < side


def test_neighbouring_items_are_one_node_s_unless_they_are_scattered():
    tiled, scattered = (machine().run(nodes=4, schedule=one, page_bytes=1024, frames=128).state.counted["faults"].sum()
                        for one in ("mixed", "scattered"))
    assert scattered > 1.3 * tiled


@pytest.mark.parametrize(("options", "message"), [
    ({"nodes": 12}, "Nodes must be a power of two up to 1024"), ({"nodes": 2048}, "Nodes must be a power of two"),
    ({"nodes": 4, "frames": 0}, "Cache must be at least one page"),
    ({"nodes": 4, "side": 0}, "Item must be at least 1"),
    ({"nodes": 4, "schedule": "none"}, "Schedule must be one of mixed, static, scattered"),
    ({"nodes": 1024, "page_bytes": 1000}, "Page bytes must be a power of two")])
def test_other_machines_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        machine().run(**options)


def test_more_tiles_than_rows_are_refused():
    with pytest.raises(InputError, match="Size must be at least 4x4 for 16 nodes, not 3x3"):
        pixel_items((3, 3), 16)
