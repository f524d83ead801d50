import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.naive import Naive
from golden.light.photometry.sensors import Sensors
from tb.golden.light.scenes import BLACK, rectangle, scene_of

FLOOR = rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0))


def test_normals_become_unit_vectors_and_planes_are_none():
    sensors = Sensors(position=[(0, 0, 0), (1, 2, 3)], normal=[(0, 0, 9), (3, 0, 4)])
    np.testing.assert_array_equal(sensors.normal, [(0, 0, 1), (0.6, 0, 0.8)])
    assert sensors.plane.tolist() == [-1, -1]
    assert len(sensors) == 2


def test_only_a_sensor_on_a_surface_has_its_patch():
    places = [(0, 0, 0), (0, 0, 1e-3), (5, 0, 0), (0.5, 0.5, 0)]
    sensors = Sensors(position=places, normal=[(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 1, -1)])
    scene = scene_of((FLOOR, BLACK))
    assert sensors.patches(scene, Naive(scene)).tolist() == [0, -1, -1, 0]


@pytest.mark.parametrize(("position", "normal", "message"), [
    ([(0, 0)], [(0, 0)], "Position and normal must be S x 3 each"),
    ([(0, 0, 0)], [(0, 0, 1)] * 2, "Position and normal must be S x 3 each"),
    (np.zeros((0, 3)), np.zeros((0, 3)), "Position and normal must be S x 3 each"),
    ([(0, 0, 0), (0, np.nan, 0)], [(0, 0, 1)] * 2, "Sensor 1 must have a finite position"),
    ([(0, 0, 0)], [(0, 0, np.inf)], "Sensor 0 must have a finite position"),
    ([(0, 0, 0)], [(0, 0, 0)], "Sensor 0 must have .* direction other than zero")])
def test_bad_sensors_are_refused(position, normal, message):
    with pytest.raises(InputError, match=message):
        Sensors(position=position, normal=normal)


@pytest.mark.parametrize("plane", [(), (0,), (0, 1, 2), ((0, 1),), 0], ids=str)
def test_each_sensor_has_its_plane(plane):
    with pytest.raises(InputError, match="Plane must be 2 numbers") as caught:
        Sensors(position=[(0, 0, 0), (1, 0, 0)], normal=[(0, 0, 1)] * 2, plane=plane)
    assert caught.value.parameter == "plane"
