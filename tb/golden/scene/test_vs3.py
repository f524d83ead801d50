import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.load import load_scene

BOX = """T two squares and a triangle between them
/ no control
F 3
! number and coordinates
V 1 0. 0. 0.
V 2 1. 0. 0.
V 3 1. 1. 0.
V 4 0. 1. 0.
v  5 0 0 1   ! comments may follow
V 6 1 0 1
V 7 1 1 1
V 8 0 1 1
V 9 .5 .5 .5

S 1  1 2 3 4  0 0 0.50 floor
S 2  8 7 6 5  0 0 0.90 lid
O 3  1 2 9 0
End of data
S what follows is not read
"""


def written(folder, text):
    path = folder / "a.vs3"
    path.write_text(text)
    return path


def test_surfaces_become_patches_in_their_order(tmp_path):
    scene = load_scene(written(tmp_path, BOX))
    assert scene.name == "a"
    np.testing.assert_array_equal(scene.vertices[0], [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    np.testing.assert_array_equal(scene.normals[:2], [(0, 0, 1), (0, 0, -1)])
    assert scene.is_triangle.tolist() == [False, False, True]
    assert not scene.two_sided.any()
    assert [scene.materials[number].name for number in scene.material] == ["floor", "lid", "obstruction"]
    np.testing.assert_allclose(scene.channels("diffuse")[:, 0], [0.5, 0.1, 0])


def test_equal_names_and_emittances_are_one_material(tmp_path):
    scene = load_scene(written(tmp_path, BOX.replace("0.90 lid", "0.50 floor")))
    assert scene.material.tolist() == [0, 0, 1]


@pytest.mark.parametrize(("old", "new", "message"), [
    ("F 3", "F 3a", "line 3: Geometry must be 3, not '3a'"),
    ("V 2", "V 3", "line 6: vertex 3 is out of sequence, 2 is next"),
    ("V 2 1.", "V 2 one", "line 6: Coordinate must be a number, not 'one'"),
    ("V 2 1.", "V 2 inf", "line 6: Coordinate must be finite"),
    ("V 2 1. 0. 0.", "V 2 1. 0.", "line 6: a vertex needs a number and three coordinates"),
    ("S 2  8", "S 4  8", "line 16: surface 4 is out of sequence, 2 is next"),
    ("S 2  8", "S 2  99", "line 16: Vertex must be a number up to 9, not 99"),
    ("S 2  8", "S 2  0", "line 16: Vertex must be a number up to 9, not 0"),
    ("S 2  8", "S 2  8.5", "line 16: Vertex must be a number, not '8.5'"),
    ("S 2  8 7 6 5  0 0 0.90 lid", "S 2  8 7 6 5", "line 16: a surface needs"),
    ("0 0 0.90", "1 0 0.90", "line 16: subsurfaces are not read"),
    ("0.90", "1.90", "line 16: Emittance must be 0 to 1, not 1.9"),
    ("O 3", "M 3", "line 17: masks and null surfaces are not read"),
    ("O 3", "X 3", "line 17: 'X' begins no known entry"),
    ("S 2  8 7 6 5", "S 2  8 6 7 5", "facet 2 is not planar and strictly convex"),
    ("O 3  1 2 9 0", "O 3  1 2 2 0", "facet 3 has no area"),
    (BOX, "T nothing\n", "it has no surfaces")])
def test_faults_are_named_with_their_line(tmp_path, old, new, message):
    path = written(tmp_path, BOX.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}: ")
