"""Trees of glTF nodes with drawn transforms, and their world matrices by rules of their own."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

__all__ = ["NodeTree", "node_trees"]

_ANGLES = st.one_of(st.sampled_from((0, 90, 180, 270, 45)), st.floats(-180, 180))
_SCALES = st.sampled_from((1.0, 0.5, 2.0, 3.0, -1.0, -2.0))
_STEPS = st.integers(-4, 4).map(float)
_AXES = st.sampled_from(((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 2, -2), (-3, 0, 4)))


@dataclass(frozen=True)
class NodeTree:
    """The nodes of a file as its JSON has them, the first one the root, and the 4 x 4 world matrix of each."""

    nodes: list[dict]
    world: list[np.ndarray]


def _turn(axis, angle):
    """Rodrigues' rotation, and the quaternion of the same rotation."""
    axis, angle = np.array(axis) / np.linalg.norm(axis), np.radians(angle)
    x, y, z = axis
    cross = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix, [*(np.sin(angle / 2) * axis).tolist(), float(np.cos(angle / 2))]


@st.composite
def _transforms(draw):
    """The members of a node that state its transform, and its 4 x 4 matrix."""
    place, scale = draw(st.tuples(*[_STEPS] * 3)), draw(st.tuples(*[_SCALES] * 3))
    turn, quaternion = _turn(draw(_AXES), draw(_ANGLES))
    members, matrix = {}, np.eye(4)
    if draw(st.booleans()):
        members["translation"] = list(place)
        matrix = matrix @ np.block([[np.eye(3), np.array(place)[:, None]], [np.zeros(3), 1]])
    if draw(st.booleans()):
        members["rotation"] = quaternion
        matrix = matrix @ np.block([[turn, np.zeros((3, 1))], [np.zeros(3), 1]])
    if draw(st.booleans()):
        members["scale"] = list(scale)
        matrix = matrix @ np.diag([*scale, 1])
    if draw(st.booleans()):
        members = {"matrix": matrix.T.ravel().tolist()}
    return members, matrix


@st.composite
def node_trees(draw, *, leaves: int) -> NodeTree:
    """Draws a tree; its last ``leaves`` nodes have no children."""
    inner = draw(st.integers(1, 4))
    nodes, world = [], []
    for number in range(inner + leaves):
        members, matrix = draw(_transforms())
        nodes.append(members)
        if number:
            parent = draw(st.integers(0, min(number, inner) - 1))
            nodes[parent].setdefault("children", []).append(number)
            matrix = world[parent] @ matrix
        world.append(matrix)
    return NodeTree(nodes, world)
