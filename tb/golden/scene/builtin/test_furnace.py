"""The furnace is a closed cube at every size."""

import numpy as np
import pytest

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
