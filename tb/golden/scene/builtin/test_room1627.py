"""room1627 is the lobby with small furniture, most of it in one corner."""

import numpy as np
import pytest

from golden.scene.builtin.lobby import LENGTH, WIDTH, lobby
from golden.scene.builtin.room1627 import room1627


@pytest.fixture(scope="module")
def scene():
    return room1627()


def test_lobby_comes_first_to_the_bit(scene):
    hall = lobby()
    count = len(hall)
    assert scene.vertices[:count].tobytes() == hall.vertices.tobytes()
    assert scene.materials[:len(hall.materials)] == hall.materials
    np.testing.assert_array_equal(scene.material[:count], hall.material)
    np.testing.assert_array_equal(scene.bounds, hall.bounds)


def test_furniture_is_small_and_crowded_in_one_corner(scene):
    furniture = scene.vertices[227:].mean(axis=1)
    crowded = (furniture[:, 0] < LENGTH / 2) & (furniture[:, 1] < WIDTH / 2)
    assert crowded.mean() > 0.7
    assert scene.areas[227:].mean() < 0.05 * scene.areas[:227].mean()


def test_only_sheets_are_two_sided(scene):
    names = {scene.materials[number].name for number in scene.material[scene.two_sided]}
    assert names == {"leaf", "paper", "lamp shade"}
