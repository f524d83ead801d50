"""Meshes, cameras and lights are where the product of their nodes' matrices puts them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.load import load_scene
from tb.golden.scene.files import gltf
from tb.golden.scene.gltf_nodes import node_trees
from tb.lib.schedules import SETTINGS

SQUARE = np.array([(0, 0, 0, 1), (1, 0, 0, 1), (1, 1, 0, 1), (0, 1, 0, 1)], dtype=float)
LIGHTS = [{"type": "point", "intensity": 2}, {"type": "spot"}, {"type": "directional"}]
LENS = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("nodes")


def unit(vector):
    return vector / np.linalg.norm(vector)


@settings(SETTINGS, max_examples=40)
@given(tree=node_trees(leaves=5), together=st.booleans())
def test_what_nodes_hold_moves_with_the_product_of_their_matrices(place, tree, together):
    """On nodes of their own, or a mesh and a camera on one, of which the other nodes are children."""
    nodes, world = [dict(node) for node in tree.nodes], tree.world
    mesh, lens, *lamps = range(len(nodes) - 5, len(nodes))
    if together:
        mesh = lens = 0
    nodes[mesh]["mesh"] = 0
    nodes[lens]["camera"] = 0
    for light, number in enumerate(lamps):
        nodes[number]["extensions"] = {"KHR_lights_punctual": {"light": light}}
    matte = {"doubleSided": False, "pbrMetallicRoughness": {"metallicFactor": 0}}
    scene = load_scene(gltf(place, nodes=nodes, cameras=LENS, materials=[matte],
                            extensions={"KHR_lights_punctual": {"lights": LIGHTS}}))
    corners = (world[mesh] @ SQUARE.T).T[:, :3]
    extent = np.abs(corners).max()
    found = scene.vertices.reshape(-1, 3)
    # Both halves of the square may stay triangles, of which one corner is repeated.
    near = np.linalg.norm(found[:, None] - corners, axis=2) <= 1e-6 * (1 + extent)
    assert near.any(axis=1).all()
    assert near.any(axis=0).all()
    normal = np.linalg.inv(world[mesh][:3, :3]).T @ (0, 0, 1)
    np.testing.assert_allclose(scene.normals, np.tile(unit(normal), (len(scene), 1)), atol=1e-6)
    eye, back, up = (world[lens][:3, column] for column in (3, 2, 1))
    camera = scene.camera
    np.testing.assert_allclose(camera.eye, eye, atol=1e-9)
    np.testing.assert_allclose(unit(np.subtract(camera.target, camera.eye)), -unit(back), atol=1e-9)
    np.testing.assert_allclose(unit(np.array(camera.up)), unit(up), atol=1e-9)
    (point,) = (light for light in scene.lights if isinstance(light, PointLight) and light.cone is None)
    (spot,) = (light for light in scene.lights if isinstance(light, PointLight) and light.cone is not None)
    (sun,) = (light for light in scene.lights if isinstance(light, DirectionalLight))
    for light, number in ((point, lamps[0]), (spot, lamps[1])):
        np.testing.assert_allclose(light.position, world[number][:3, 3], atol=1e-9)
    assert point.intensity == (2, 2, 2)
    for direction, number in ((spot.cone.direction, lamps[1]), (sun.direction, lamps[2])):
        np.testing.assert_allclose(unit(np.array(direction)), -unit(world[number][:3, 2]), atol=1e-9)


@pytest.mark.filterwarnings("ignore:.*length of a rotation:golden.base.errors.InputWarning")
@pytest.mark.parametrize("length", [1e-3, 0.99, 2])
def test_a_rotation_of_any_length_turns_alone(place, length):
    half = np.sqrt(0.5) * length
    scene = load_scene(gltf(place, nodes=[{"mesh": 0, "rotation": [0, 0, half, half]}]))
    corners = scene.vertices.reshape(-1, 3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [(-1, 0, 0), (0, 1, 0)], atol=1e-12)


def test_a_rotation_of_length_0_is_refused(place):
    with pytest.raises(InputError, match="a rotation is 0, which is no quaternion of length 1"):
        load_scene(gltf(place, nodes=[{"mesh": 0, "rotation": [0, 0, 0, 0]}]))
