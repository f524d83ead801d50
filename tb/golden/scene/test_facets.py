import numpy as np
import pytest
import trimesh

from golden.base.errors import InputError
from golden.scene.load import load_scene
from golden.scene.open import open_scene

# A square as two triangles, the square again, and a triangle that faces the other way.
POINTS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 0\nv 0.5 0.2 0\nv 0 1 1\n"
FACES = "f 1 2 3\nf 1 3 4\nf 1 2 3 4\nf 3 2 1\n"


def test_each_face_is_one_patch_in_its_order(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text(POINTS + FACES)
    scene = open_scene(path, facets=True)
    assert scene.is_triangle.tolist() == [True, True, False, True]
    np.testing.assert_array_equal(scene.normals[:, 2], [1, 1, 1, -1])
    np.testing.assert_array_equal(scene.vertices[1], [(0, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 0)])
    assert not scene.two_sided.any()
    assert scene.surface.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_facets_of_stl_stay_triangles(tmp_path, kind):
    box = trimesh.creation.box()
    box.export(tmp_path / "a.stl", file_type=kind)
    scene = load_scene(tmp_path / "a.stl", facets=True)
    np.testing.assert_allclose(scene.vertices[:, :3], box.triangles)
    assert len(load_scene(tmp_path / "a.stl")) == 6


@pytest.mark.parametrize(("face", "area"), [
    ("1 2 3 8 4", 1 + 0.5), ("1 2 6 4", (0.2 + 0.5) / 2), ("1 2 9 3 4", 1), ("1 2 3 4 6", 1 - 0.25)])
def test_other_polygons_are_surfaces_of_several_patches(tmp_path, face, area):
    """A house, a concave quad, a square with a corner within a side, and one with a notch, between triangles."""
    path = tmp_path / "a.obj"
    path.write_text(f"{POINTS}v 0.5 2 0\nv 1 0.3 0\nf 1 2 3\nf {face}\nf 3 2 1\n")
    scene = open_scene(path, facets=True)
    assert scene.surface.tolist() == [0, *[1] * (len(scene) - 2), 2]
    assert len(scene) > 3
    assert scene.areas[1:-1].sum() == pytest.approx(area)
    np.testing.assert_allclose(scene.normals[1:-1], [(0, 0, 1)] * (len(scene) - 2))


@pytest.mark.parametrize(("faces", "message"), [
    ("f 1 2 3\nf 1 2 3 7\n", "facet 2: it is not planar"), ("f 1 2 5 4 7\n", "facet 1: it is not planar"),
    ("f 1 2 4 3 6\n", "facet 1: polygon: it crosses itself"), ("f 1 3 5\n", "face 1 has no area")])
def test_faces_that_are_no_patches_are_refused(tmp_path, faces, message):
    path = tmp_path / "a.obj"
    path.write_text(POINTS + faces)
    with pytest.raises(InputError, match=message):
        load_scene(path, facets=True)
