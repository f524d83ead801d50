import numpy as np
import pytest

from golden.errors import InputError
from golden.light.photometry.sensor_file import MOST, read_sensors

PLANE = "plane 0 0 1  2 0 0  0 3 0  2 3\n"


def read(folder, text):
    path = folder / "points.txt"
    path.write_text(text, encoding="utf-8")
    return read_sensors(path)


def test_points_keep_their_order_and_comments_count_for_nothing(tmp_path):
    sensors = read(tmp_path, "# a desk\n\n1 2 3  0 0 2\n4,5,6,0,-1,0 # the wall\n")
    np.testing.assert_array_equal(sensors.position, [(1, 2, 3), (4, 5, 6)])
    np.testing.assert_array_equal(sensors.normal, [(0, 0, 1), (0, -1, 0)])
    assert sensors.plane.tolist() == [-1, -1]


def test_a_plane_has_a_sensor_at_the_centre_of_each_field(tmp_path):
    sensors = read(tmp_path, PLANE)
    np.testing.assert_allclose(sensors.position, [(0.5, 0.5, 1), (1.5, 0.5, 1), (0.5, 1.5, 1), (1.5, 1.5, 1),
                                                  (0.5, 2.5, 1), (1.5, 2.5, 1)])
    assert (sensors.normal == (0, 0, 1)).all()


def test_a_byte_order_mark_is_no_part_of_the_first_line(tmp_path):
    assert read(tmp_path, "\ufeff1 2 3 0 0 1\n").position.tolist() == [[1, 2, 3]]


def test_planes_are_numbered_and_points_between_them_are_not(tmp_path):
    sensors = read(tmp_path, f"{PLANE}0 0 0 0 0 1\nplane 0 0 0  0 1 0  1 0 0  1 1\n")
    assert sensors.plane.tolist() == [0] * 6 + [-1, 1]
    assert sensors.normal[-1].tolist() == [0, 0, -1]


@pytest.mark.parametrize(("text", "message"), [
    ("", "it has no sensors"), ("# nothing\n", "it has no sensors"),
    ("0 0 0 0 0 1\n0 0 0 0 0\n", "line 2: Values must be the numbers x y z nx ny nz, not '0 0 0 0 0'"),
    ("0 0 0 0 0 up\n", "line 1: Values must be"), ("0 0 0 0 0 nan\n", "line 1: Sensor 0 must have a finite"),
    ("0 0 0 0 0 0\n", "line 1: Sensor 0 must have"), ("plane 0 0 0 1 0 0 0 1 0 2\n", "line 1: Values must be"),
    ("plane 0 0 0 1 0 0 0 1 0 2 0\n", "line 1: Steps of a plane must be"),
    ("plane 0 0 0 1 0 0 0 1 0 2 1.5\n", "line 1: Steps of a plane must be"),
    ("plane 0 0 0 1 0 0 2 0 0 2 2\n", "direction other than zero"),
    ("plane 0 0 0 1 0 0 0 1 0 1e9 1e9\n", f"line 1: Sensors must be at most {MOST}"),
    ("plane 0 0 0 1 0 0 0 1 0 1000 1000\n0 0 0 0 0 1\n", f"line 2: Sensors must be at most {MOST}")])
def test_a_bad_file_is_one_line_with_its_place(tmp_path, text, message):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'points.txt'}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_no_text_file_is_refused(tmp_path):
    (tmp_path / "points.txt").write_bytes(b"\xff\xfe\0")
    for path in (tmp_path, tmp_path / "points.txt", tmp_path / "nothing.txt"):
        with pytest.raises(InputError, match=r"cannot be read|not a regular file"):
            read_sensors(path)
