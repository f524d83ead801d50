"""PLY files in every dialect that their definition allows."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings

from golden.base.errors import InputError
from golden.scene.appearance import from_srgb
from golden.scene.ply import read_ply
from tb.golden.scene.dialects import DAMAGES, damaged
from tb.golden.scene.files import refusal
from tb.golden.scene.ply_files import ply_files
from tb.lib.schedules import SETTINGS


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("ply") / "a.ply"


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("examples", [40, pytest.param(500, marks=pytest.mark.nightly)])
def test_vertices_corners_and_colours_are_read_whatever_their_types_and_order(place, examples):
    settings(SETTINGS, max_examples=examples)(given(file=ply_files())(lambda file: reads(place, file)))()


def reads(place, file):
    place.write_bytes(file.data)
    mesh = read_ply(place)
    assert mesh.points.tolist() == [list(point) for point in file.points]
    assert [part.tolist() for part in np.split(mesh.corners, np.cumsum(mesh.counts)[:-1])] == [
        *file.faces, *(triangle for strip in file.strips for triangle in triangles(strip))]
    found = np.array([mesh.materials[number].diffuse for number in mesh.material])
    if file.colour_kind is None:
        assert (found == 0.5).all()
    else:
        stated = np.array(file.colours, dtype=np.float64)
        floats = file.colour_kind[0] in "fd"
        most = 1 if floats else np.iinfo({"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4",
                                          "uint": "u4"}.get(file.colour_kind, file.colour_kind)).max
        linear = np.clip(stated / most, 0, 1)
        linear = linear if floats else from_srgb(linear)
        # Rounded to 8 bits of sRGB, of which a step is at most 0.009 in linear units.
        np.testing.assert_allclose(found, linear, atol=0.005)


def triangles(strip):
    """Each corner with the two before it, since -1 or the begin; of every other one these are exchanged."""
    found, before = [], []
    for corner in strip:
        if corner == -1:
            before = []
            continue
        before.append(corner)
        first, second = before[-3:-1] if len(before) > 2 else (corner, corner)
        if len({first, second, corner}) == 3:
            found.append([first, second, corner] if len(before) % 2 else [second, first, corner])
    return found


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@settings(SETTINGS, max_examples=12)
@given(file=ply_files())
def test_a_file_without_its_last_byte_is_refused_or_ends_in_a_word(place, file):
    place.write_bytes(file.data[:-1])
    if b"format ascii" in file.data:
        assert len(read_ply(place).counts) == len(file.faces) + sum(map(len, map(triangles, file.strips)))
    else:
        with pytest.raises(InputError, match="it ends within its"):
            read_ply(place)


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("examples", [40, pytest.param(500, marks=pytest.mark.nightly)])
def test_a_damaged_file_is_read_or_refused_in_one_line(place, examples):
    @settings(SETTINGS, max_examples=examples)
    @given(file=ply_files(), damage=DAMAGES)
    def refuses(file, damage):
        place.write_bytes(damaged(file.data, damage))
        message = refusal(place)
        assert message is None or (message.startswith(str(place)) and "\n" not in message)
    refuses()


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize(("name", "code"), [("float", "f"), ("double", "d")])
@pytest.mark.parametrize("length", [3.5, 2.75, 0.25, np.nan, np.inf])
def test_the_length_of_a_list_is_a_whole_number(place, kind, name, code, length):
    head = (f"ply\nformat {kind} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face 2\nproperty list {name} int vertex_indices\nend_header\n").encode()
    order = ">" if "big" in kind else "<"
    rows = b"".join([struct.pack(order + "9f", 0, 0, 0, 1, 0, 0, 0, 1, 0), struct.pack(order + code + "3i", 3, 0, 1, 2),
                     struct.pack(order + code + "3i", length, 2, 1, 0)])
    place.write_bytes(head + (f"0 0 0 1 0 0 0 1 0 3 0 1 2 {length} 2 1 0".encode() if kind == "ascii" else rows))
    assert refusal(place) == f"{place}: a value in its face rows is not a number of its type"
