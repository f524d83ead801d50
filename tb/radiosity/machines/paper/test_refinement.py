"""The host shoots the patch with most unshot light."""

import numpy as np

from golden.scene.material import Material
from golden.scene.scene import Scene
from radiosity.machines.paper.refinement import Refinement


def scene(*materials):
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    vertices = np.stack([corner * (1 + number) + [0, 0, number] for number in range(len(materials))])
    return Scene(name="plates", vertices=vertices, material=np.arange(len(materials)), materials=materials)


LAMP, GREY = Material(name="lamp", diffuse=(0.5,) * 3, emission=(8.0,) * 3), Material(name="grey", diffuse=(0.5,) * 3)


def test_the_most_light_shoots_and_arrives():
    host = Refinement(scene(LAMP, GREY, GREY))
    assert host.choose() == 0
    host.shoot(0, np.array([0.0, 0.25, 0.5]))
    # Areas are 1, 4 and 9: what arrives is spread over them, and half of it is reflected.
    assert np.allclose(host.unshot, [[0] * 3, [0.25 / 4 * 8 / 2] * 3, [0.5 / 9 * 8 / 2] * 3])
    assert host.choose() == 2


def test_a_scene_without_light_emits_everywhere():
    assert Refinement(scene(GREY, GREY)).choose() == 1
