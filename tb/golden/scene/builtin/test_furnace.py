"""The furnace is a closed cube at every size."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.builtin.furnace import furnace
from tb.golden.scene.builtin.solids import is_closed, volume


@pytest.mark.parametrize("size", [1, 3, 7, 8])
def test_cube_is_closed_to_the_bit_with_fronts_inside(size):
    scene = furnace(size)
    assert len(scene) == 6 * size**2
    assert is_closed(scene.vertices)
    assert volume(scene.vertices) == pytest.approx(-1)
    np.testing.assert_allclose(scene.areas, 1 / size**2)


def test_each_face_is_one_surface():
    scene = furnace(4)
    assert len(np.unique(scene.surface)) == 6
    for surface in range(6):
        assert len(np.unique(scene.normals[scene.surface == surface], axis=0)) == 1


def test_default_shines_with_two():
    (material,) = furnace(2).materials
    assert np.divide(material.emission, np.subtract(1, material.diffuse)).tolist() == [2, 2, 2]


def test_one_face_can_be_the_only_and_black_emitter():
    scene = furnace(2, diffuse=0.5, emission=3.0, emitter="+z")
    ceiling = scene.normals[:, 2] == -1
    assert (scene.channels("emission")[ceiling] == 3).all()
    assert (scene.channels("emission")[~ceiling] == 0).all()
    assert (scene.channels("diffuse")[ceiling] == 0).all()
    assert (scene.channels("diffuse")[~ceiling] == 0.5).all()
    assert (scene.vertices[ceiling, :, 2] == 1).all()


@pytest.mark.parametrize(("arguments", "message"), [
    ({"size": 0}, "Size must be at least 1, not 0"),
    ({"emitter": "top"}, "Emitter must be one of -x, .*, not 'top'"),
    ({"diffuse": 1.5}, "at most 1"),
])
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        furnace(**arguments)
