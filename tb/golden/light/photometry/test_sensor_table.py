import numpy as np
import pytest

from golden.light.photometry.sensor_table import plane_figures, sensor_rows
from golden.light.photometry.sensors import Sensors

SENSORS = Sensors(position=np.arange(12).reshape(4, 3), normal=np.tile((0, 0, 2), (4, 1)), plane=[-1, 0, 0, 1])
LUX = np.array([100.0, 300, 500, 0])


def test_each_sensor_has_a_row():
    head, *rows = sensor_rows(SENSORS, LUX)
    assert head == ("sensor", "plane", "x", "y", "z", "nx", "ny", "nz", "illuminance")
    assert rows[0] == (0, "", 0, 1, 2, 0, 0, 1, 100)
    assert rows[2] == (2, 0, 6, 7, 8, 0, 0, 1, 500)


def test_each_plane_has_mean_extremes_and_uniformity():
    single, first, dark = plane_figures(SENSORS, LUX)
    assert single["plane"] is None
    assert first == {"plane": 0, "sensors": 2, "mean": 400, "minimum": 300, "maximum": 500,
                     "uniformity": pytest.approx(0.75)}
    assert dark["uniformity"] == 0
