"""The telephone has what it needs."""

import numpy as np
import pytest

from golden.scene.builtin.phone import phone


@pytest.fixture(scope="module")
def scene():
    return phone()


def test_cord_lies_on_the_desk_without_sinking_in(scene):
    group = np.bincount(scene.smooth).argmax()
    cord = scene.vertices[scene.smooth == group]
    assert 0 < cord[..., 2].min() < 0.3
