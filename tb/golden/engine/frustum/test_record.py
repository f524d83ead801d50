import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Numbers
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.frustum.record import LEAST_Z_SCALE
from golden.engine.scene.g_coordinates import GCoordinates
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera

UNIT = 2.0**-16


@pytest.fixture(scope="module")
def coordinates():
    return GCoordinates.of(builtin_scene("cornell"), Numbers())


def view(coordinates, width, height, fov):
    camera = Camera(eye=coordinates.bounds.mean(axis=0), target=coordinates.bounds[1], fov=fov)
    screen = Screen(camera=camera, width=width, height=height)
    return screen, screen_record(screen, coordinates)


@pytest.mark.parametrize("rays", [(4, 4), (64, 16), (1024, 256), (64, 4096)])
def test_hemisphere_directions_are_the_floats_within_three_roundings(coordinates, rays):
    hemisphere = Hemisphere(*rays)
    record = hemisphere_record(hemisphere, coordinates, coordinates.bounds.mean(axis=0), (0, 3, 4))
    column, row = np.arange(rays[0])[:, None], np.unique([0, 1, rays[1] // 2, rays[1] - 1])
    exact = hemisphere.directions[row * rays[0] + column]
    integers = record.directions(column, row)
    assert np.abs(integers * UNIT - exact).max() <= 1.5 * UNIT
    # The angle between the two, as the windows' margin assumes.
    assert np.linalg.norm(np.cross(integers * UNIT, exact), axis=-1).max() <= 2.2 * UNIT
    assert (integers[..., 2] > 0).all()
    assert np.linalg.norm(integers, axis=-1).max() <= record.longest_direction


@pytest.mark.parametrize(("width", "height", "fov"), [(64, 64, 40), (640, 480, 40), (33, 7, 120), (1, 1, 90),
                                                      (100, 300, 1)])
def test_screen_rays_are_those_of_the_camera(coordinates, width, height, fov):
    screen, record = view(coordinates, width, height, fov)
    exact = screen.rays().direction
    # What the folded matrix makes of the true direction is a multiple of the table's.
    seen = exact @ (record.matrix * UNIT).T
    table = record.all_directions() * UNIT
    assert np.abs(seen / seen[:, 2:] - table).max() * record.z_scale * UNIT <= 4 * UNIT
    assert np.abs(seen[:, 2] - record.z_scale * UNIT).max() <= 4 * UNIT * np.linalg.norm(exact, axis=1).max()


@pytest.mark.parametrize("fov", [1, 40, 90, 150])
def test_grid_rays_of_a_screen_have_scaled_slopes(coordinates, fov):
    screen, record = view(coordinates, 96, 64, fov)
    half = np.tan(np.radians(fov) / 2)
    assert record.slopes == pytest.approx((1.5 * half, half))
    assert record.slope_scale == pytest.approx(1.125 * max(1, 1.5 * half))
    local = np.stack([screen.rays().direction @ axis for axis in screen.camera.axes * [[1], [-1], [1]]], axis=1)
    given = local / [record.slope_scale, record.slope_scale, 1]
    assert np.abs(given @ (record.to_global * UNIT).T * record.slope_scale - screen.rays().direction).max() \
        <= 2 * UNIT * record.slope_scale


@pytest.mark.parametrize("bits", [10, 16])
def test_what_a_ray_meets_is_as_deep_as_its_least_z_scale_and_other_frames_are_refused(bits):
    coordinates, random = GCoordinates.of(builtin_scene("cornell"), Numbers(direction_fraction=bits)), \
        np.random.default_rng(bits)
    refused = 0
    for _ in range(300):
        width, height = (int(2 ** random.uniform(0, bits)) for _ in range(2))
        # The least field of view is that of the message, of three digits.
        with pytest.raises(InputError, match="Field of view must be at least") as error:
            view(coordinates, width, height, 1e-9)
        assert error.value.parameter == "fov"
        fov, least = float(10 ** random.uniform(-4, 2)), float(str(error.value).split(" degrees")[0].split()[-1])
        if fov < 1.01 * least:
            refused += 1
            with pytest.raises(InputError, match="Field of view"):
                view(coordinates, width, height, min(fov, 0.99 * least))
            fov = 1.01 * least
        screen, record = view(coordinates, width, height, fov)
        corners = np.array([0, width - 1, width * (height - 1), width * height - 1])
        depth = screen.rays(corners).direction @ record.matrix[2]
        assert LEAST_Z_SCALE * 0.957 < record.least_z_scale <= depth.min()
        assert depth.max() <= 2 * record.z_scale - record.least_z_scale
    assert refused > 30


def test_the_largest_row_of_a_screens_matrix_is_of_unit_length(coordinates):
    for fov in 1, 40, 90, 150:
        _, record = view(coordinates, 96, 64, fov)
        assert np.linalg.norm(record.matrix * UNIT, axis=1).max() == pytest.approx(1, abs=2 * UNIT)


def test_screen_tables_are_exact_and_grids_powers_of_two(coordinates):
    _, record = view(coordinates, 640, 480, 40)
    assert (record.column_bits, record.row_bits) == (10, 9)
    assert (record.column_table[:, 0] == (2 * np.arange(640) - 639) * 2**6).all()
    assert (record.row_table[:, 0] == (2 * np.arange(480) - 479) * 2**7).all()


def test_hemisphere_matrix_is_the_frame_of_the_normal(coordinates):
    record = hemisphere_record(Hemisphere(8, 4), coordinates, coordinates.bounds.mean(axis=0), (0, 3, 4), source=7)
    assert np.abs(record.matrix * UNIT - frame((0, 0.6, 0.8))).max() <= UNIT / 2
    assert (record.to_global == record.matrix.T).all()
    assert record.source == 7


@pytest.mark.parametrize("normal", [(0, 0, 0), (0, np.nan, 1), (np.inf, 0, 0)])
def test_a_normal_without_direction_is_refused(coordinates, normal):
    with pytest.raises(InputError, match=r"^frustum: Normal must be finite and not zero, not "):
        hemisphere_record(Hemisphere(8, 4), coordinates, coordinates.bounds.mean(axis=0), normal)


def test_an_origin_outside_the_coordinates_is_refused(coordinates):
    with pytest.raises(InputError, match="within the scene's coordinates"):
        hemisphere_record(Hemisphere(8, 4), coordinates, coordinates.bounds[1] * 10 + 10, (0, 0, 1))
