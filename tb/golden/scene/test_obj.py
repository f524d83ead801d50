"""OBJ files in the dialects that programs write."""

import numpy as np
import pytest
from hypothesis import given, settings
from PIL import Image

from golden.scene.obj import read_obj
from golden.scene.textures import face_mappings
from tb.golden.scene.obj_files import obj_files
from tb.lib.schedules import SETTINGS


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("obj")
    Image.new("RGB", (2, 2), "white").save(folder / "p.png")
    (folder / "a.mtl").write_text("newmtl a\nmap_Kd p.png\n")
    return folder / "a.obj"


@pytest.mark.filterwarnings("ignore::golden.errors.InputWarning")
@pytest.mark.parametrize("examples", [50, pytest.param(500, marks=pytest.mark.nightly)])
def test_vertices_corners_and_texture_coordinates_are_those_that_a_face_names(place, examples):
    settings(SETTINGS, max_examples=examples)(given(file=obj_files())(lambda file: reads(place, file)))()


def reads(place, file):
    place.write_bytes(("mtllib a.mtl\nusemtl a\n" + file.text).encode())
    mesh = read_obj(place)
    assert mesh.points.tolist() == [list(point) for point in file.points]
    assert [part.tolist() for part in np.split(mesh.corners, np.cumsum(mesh.counts)[:-1])] == [
        [point for point, _ in face] for face in file.faces]
    for number, face in enumerate(file.faces):
        points = np.array([file.points[point] for point, _ in face])
        uv = np.array([file.uv[named] if named >= 0 else (0, 0) for _, named in face])
        mapping, is_affine = face_mappings(points, uv, np.array([len(face)]))
        has_picture = face[0][1] >= 0 and is_affine[0]
        assert (mesh.textures is not None and mesh.textures.picture[number] == 0) == has_picture
        if has_picture:
            np.testing.assert_array_equal(mesh.textures.mapping[number], mapping[0])
