"""The telephone has what it needs."""

import numpy as np
import pytest

from golden.scene.builtin.phone import STROKES, phone


@pytest.fixture(scope="module")
def scene():
    return phone()


def _of(scene, name):
    return scene.vertices[[scene.materials[number].name == name for number in scene.material]]


def test_keys_carry_their_print(scene):
    assert len(_of(scene, "print")) == sum(map(len, STROKES.values())) + sum(len(STROKES[digit]) for digit in "2271297")
    assert len(_of(scene, "ivory key")) == 12 * (12 + 12 + 5)


def test_handset_and_cord_are_smooth(scene):
    red = scene.vertices[[scene.materials[number].name == "red plastic" for number in scene.material]]
    sizes = np.unique(scene.smooth, return_counts=True)[1]
    assert sizes.max() == 2 * 5 * 243
    assert len(red) > 2 * 5 * 243


def test_cord_lies_on_the_desk_without_sinking_in(scene):
    group = np.bincount(scene.smooth).argmax()
    cord = scene.vertices[scene.smooth == group]
    assert 0 < cord[..., 2].min() < 0.3
