"""Windows hold every ray that meets their patch: SBB and IPBB against all patches x all rays."""

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from tb.golden.engine.icu.patches import CONFIG, KINDS, brute_hits, hard_patches, hemisphere, meeting, screen, setup

RECORDS = {"64 x 16": hemisphere(64, 16), "16 x 64": hemisphere(16, 64), "4 x 4": hemisphere(4, 4),
           "4 x 4096": hemisphere(4, 4096), "4096 x 4": hemisphere(4096, 4),
           "64 x 64 pixels": screen(64, 64), "50 x 30 pixels": screen(50, 30, 120.0),
           "1 x 33 pixels": screen(1, 33, 5.0)}


def lost(windows, record, vertices):
    directions, planes = setup(vertices)
    window = windows.windows(directions, planes)
    patch, ray = meeting(planes, record.all_directions())
    row, column = np.divmod(ray, record.columns)
    return np.count_nonzero(~window[patch].holds(column, row, record.columns)), len(patch), window


@pytest.mark.parametrize("name", RECORDS)
def test_no_ray_of_a_patch_is_outside_its_window(name):
    record = RECORDS[name]
    windows = (ImagePlaneWindows if record.is_screen else SphericalWindows)(record, CONFIG)
    for kind in KINDS:
        missed, met, _ = lost(windows, record, hard_patches(kind, 1, 80))
        assert missed == 0, kind
        assert met > 0, kind


def test_no_ray_of_a_patch_with_corners_in_the_table_is_outside_its_window():
    """At random distances, half of them at the pole."""
    record, random = hemisphere(512, 32), np.random.default_rng(3)
    column = random.integers(0, record.columns, (200, 1))
    row = np.where(np.arange(200) % 2, 0, random.integers(0, record.rows - 3, 200))[:, None]
    corners = record.directions((column + np.array([0, 3, 3, 0])) % record.columns, row + np.array([0, 0, 2, 2]))
    vertices = np.rint(corners * random.uniform(8, 36, (200, 4, 1))).astype(np.int64)
    assert lost(SphericalWindows(record, CONFIG), record, vertices)[0] == 0


def test_a_window_goes_on_over_azimuth_0():
    record = hemisphere(16, 8)
    corners = record.directions(np.array([14, 1, 1, 14]), np.array([2, 2, 4, 4])) * 32
    window = lost(SphericalWindows(record, CONFIG), record, corners[None])[2]
    assert (window.column_first[0], window.column_count[0], window.row_count[0]) == (14, 4, 3)
    assert window.holds(np.arange(16), 3, 16).nonzero()[0].tolist() == [0, 1, 14, 15]


def test_a_patch_over_the_pole_has_the_whole_ring_from_row_0():
    record = hemisphere(16, 8)
    square = np.array([[[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]]) * 2**20
    window = lost(SphericalWindows(record, CONFIG), record, square)[2]
    assert (window.column_first[0], window.column_count[0], window.row_first[0]) == (0, 16, 0)
    # The corners are 54.7 degrees from the normal, in row 4 of 11.25 degrees each.
    assert window.row_count[0] == 5


def test_patches_below_the_horizon_and_behind_the_eye_have_no_rays():
    below = np.array([[[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]],
                      [[1, 1, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0]],
                      [[1, 1, 0], [2, 1, 0], [2, 1, -1], [1, 1, -1]]]) * 2**18
    for record, windows in ((hemisphere(16, 8), SphericalWindows), (screen(16, 16), ImagePlaneWindows)):
        assert (lost(windows(record, CONFIG), record, below)[2].rays == 0).all()


def test_a_floor_under_the_eye_reaches_the_lower_border_only():
    record = screen(64, 64)
    floor = np.array([[[-4, 1, -4], [4, 1, -4], [4, 1, 4], [-4, 1, 4]]]) * 2**18
    window = lost(ImagePlaneWindows(record, CONFIG), record, floor)[2]
    assert window.row_first[0] + window.row_count[0] == 64
    # Its far edge is at slope 1/4 of at most 1; y runs down.
    assert abs(int(window.row_first[0]) - 40) <= 1


def test_windows_are_tight():
    scene = builtin_scene("lobby")
    random = np.random.default_rng(7)
    held = met = 0
    for _ in range(2):
        origin = scene.bounds[0] + random.uniform(0.2, 0.8, 3) * (scene.bounds[1] - scene.bounds[0])
        geometry = PatchGeometry.of(scene, CONFIG.numbers, origin)
        record = hemisphere_record(Hemisphere(128, 64), geometry.coordinates, origin, (0, 0, -1))
        patches = PatchSetup(record, CONFIG).patches(geometry)
        held += patches.window.rays.sum()
        met += brute_hits(patches.planes, record.all_directions()).sum()
    assert 1 <= held / met < 1.75, "rays in windows per ray inside a patch"
