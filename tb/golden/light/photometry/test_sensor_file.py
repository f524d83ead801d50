import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.light.photometry.sensor_file import MOST, read_sensors
from tb.lib.schedules import SETTINGS


def read(folder, text):
    path = folder / "points.txt"
    path.write_text(text, encoding="utf-8")
    return read_sensors(path)


NUMBER = st.integers(-4, 4).map(lambda value: value / 2)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER)


@st.composite
def lines(draw):
    """The words of a line with its sensors: points, directions and whether they are of a plane; or a comment."""
    kind = draw(st.sampled_from(("point", "plane", "nothing")))
    if kind == "nothing":
        return draw(st.sampled_from(("", "# 1 2 3 0 0 1"))), []
    corner = np.array(draw(VECTOR))
    if kind == "point":
        normal = np.array(draw(VECTOR.filter(any)))
        words, sensors = [*corner, *normal], [(corner, normal / np.linalg.norm(normal))]
    else:
        along, up = np.array([(2.0, 0, 0), (0, 0, 3.0)])[draw(st.permutations([0, 1]))]
        m, n = draw(st.integers(1, 3)), draw(st.integers(1, 3))
        normal = np.cross(along, up) / 6
        words = [*corner, *along, *up, m, n]
        sensors = [(corner + (i + 0.5) / m * along + (j + 0.5) / n * up, normal) for j in range(n) for i in range(m)]
    text = draw(st.sampled_from((" ", "  ", "\t", ",", ", "))).join(map(str, words))
    return ("plane " if kind == "plane" else "") + text + draw(st.sampled_from(("", " ", " # 1"))), sensors


@settings(SETTINGS, max_examples=60)
@given(st.lists(lines(), max_size=5), st.sampled_from(("utf-8", "utf-8-sig", "utf-16", "latin-1")),
       st.sampled_from(("\n", "\r\n", "\r")))
def test_points_and_planes_are_read_in_their_order(tmp_path_factory, rows, encoding, end):
    """Planes are numbered, points between them are not; of a plane the first edge runs fastest."""
    rows = [*rows, ("1 2 3 0 0 1", [(np.array((1.0, 2, 3)), np.array((0, 0, 1.0)))])]
    path = tmp_path_factory.getbasetemp() / "points.txt"
    path.write_bytes(("# Höhe" + end + end.join(text for text, _ in rows) + end).encode(encoding))
    sensors = read_sensors(path)
    expected = [sensor for _, found in rows for sensor in found]
    np.testing.assert_allclose(sensors.position, [position for position, _ in expected], atol=1e-12)
    np.testing.assert_allclose(sensors.normal, [normal for _, normal in expected], atol=1e-12)
    planes, number = [], 0
    for text, found in rows:
        is_plane = text.startswith("plane")
        planes += [number if is_plane else -1] * len(found)
        number += is_plane
    assert sensors.plane.tolist() == planes


@pytest.mark.parametrize(("text", "message"), [
    ("", "it has no sensors"), ("# nothing\n", "it has no sensors"),
    ("0 0 0 0 0 1\n0 0 0 0 0\n", "line 2: Values must be the numbers x y z nx ny nz, not '0 0 0 0 0'"),
    ("0 0 0 0 0 up\n", "line 1: Values must be"), ("0 0 0 0 0 nan\n", "line 1: Sensor 0 must have a finite"),
    ("0 0 1_0 0 0 1\n", "line 1: Values must be"),
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
    (tmp_path / "points.txt").write_bytes(bytes(range(256)))
    for path in (tmp_path, tmp_path / "points.txt", tmp_path / "nothing.txt"):
        with pytest.raises(InputError, match=r"cannot be read|not a regular file|Values must be"):
            read_sensors(path)
