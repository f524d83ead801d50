import numpy as np
import pytest

from golden.scene.builtin.teapot import CONTROL_POINTS, teapot
from golden.scene.tessellate import bezier

PARTS = {"rim": slice(0, 4), "body": slice(4, 12), "handle": slice(12, 16), "spout": slice(16, 20),
         "lid": slice(20, 28), "bottom": slice(28, 32)}


def counted(patches):
    """Triangles, a quad as two."""
    return len(patches) + (patches[:, 3] != patches[:, 2]).any(axis=1).sum()


@pytest.mark.parametrize(("size", "triangles"), [(1, 52), (2, 240), (3, 552), (12, 9120)])
def test_teapot_has_the_published_number_of_triangles(size, triangles):
    """9120 and 144 squares of the board are the 9264 primitives of SPD's default size.

    Size 1 is published with 56, but four of them, at the tip of the spout, have no area.
    """
    scene = teapot(size)
    ceramic = np.array([material.name == "glaze" for material in scene.materials])[scene.material]
    board = np.array(["square" in material.name for material in scene.materials])[scene.material]
    assert counted(scene.vertices[ceramic]) == triangles
    assert board.sum() == size * size


@pytest.mark.parametrize("point", [
    (1.4, -0.784, 2.4), (0.749, -1.3375, 2.53125), (-0.805, 1.4375, 2.53125), (2.0, 1.12, 0.45), (-1.6, -0.3, 2.025),
    (-2.65, 0.3, 0.9375), (-1.9, 0.0, 0.6), (3.525, 0.25, 2.49375), (3.45, -0.15, 2.5125), (0.8, -0.45, 3.15),
    (-0.45, 0.8, 3.15), (0.0, 0.0, 2.85), (0.112, 0.2, 2.7), (-0.728, -1.3, 2.4), (-0.798, 1.425, 0.0),
    (0.0, 0.0, 0.0)])
def test_control_points_are_the_published_ones_to_the_bit(point):
    assert (point == CONTROL_POINTS).all(axis=-1).any()


def test_control_points_have_the_published_shape():
    assert CONTROL_POINTS.shape == (32, 4, 4, 3)
    points = np.unique(CONTROL_POINTS.reshape(-1, 3), axis=0)
    assert points.min(axis=0).tolist() == [-3, -2, 0]
    assert points.max(axis=0).tolist() == [3.525, 2, 3.15]
    assert not CONTROL_POINTS.flags.writeable


@pytest.mark.parametrize("part", PARTS)
def test_fronts_are_outside(part):
    patches = bezier(CONTROL_POINTS[PARTS[part]], cuts=4)
    vectors = 0.5 * np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])
    centers = patches.mean(axis=1)
    if part in ("handle", "spout"):
        # Around the tube, in the plane across it.
        assert (vectors[:, 1] * centers[:, 1]).sum() > 0.9 * np.abs(vectors[:, 1] * centers[:, 1]).sum()
    elif part == "rim":
        ring = centers * (1, 1, 0)
        ring *= 1.44 / np.linalg.norm(ring, axis=1, keepdims=True)
        assert (vectors * (centers - ring - (0, 0, 2.4))).sum(axis=1).min() > 0
    else:
        middle = {"body": (0, 0, 1), "lid": (0, 0, 2), "bottom": (0, 0, 1)}[part]
        volume = (vectors * (centers - middle)).sum(axis=1)
        assert volume.sum() > 0.9 * np.abs(volume).sum()


@pytest.mark.parametrize("cuts", [2, 3, 8])
def test_neighbouring_bezier_patches_share_their_corners(cuts):
    """Only where the surface ends (rim's and lid's edge, both ends of handle and spout) has an edge one patch."""
    borders = {"rim": 8, "body": 8, "handle": 4, "spout": 4, "lid": 4, "bottom": 4}
    for part, sides in borders.items():
        patches = bezier(CONTROL_POINTS[PARTS[part]], cuts=cuts)
        _, corner = np.unique(patches.reshape(-1, 3), axis=0, return_inverse=True)
        start = corner.reshape(-1, 4)
        end = np.roll(start, -1, axis=1)
        edges = list(zip(start[start != end].tolist(), end[start != end].tolist(), strict=True))
        there = set(edges)
        single = [edge for edge in edges if edge[::-1] not in there]
        assert (part, len(single)) == (part, sides * cuts)


def test_body_and_bottom_are_one_surface_with_the_rim():
    patches = bezier(np.concatenate([CONTROL_POINTS[PARTS[part]] for part in ("rim", "body", "bottom")]), cuts=5)
    _, corner = np.unique(patches.reshape(-1, 3), axis=0, return_inverse=True)
    start = corner.reshape(-1, 4)
    end = np.roll(start, -1, axis=1)
    edges = set(zip(start[start != end].tolist(), end[start != end].tolist(), strict=True))
    assert sum(edge[::-1] not in edges for edge in edges) == 4 * 5
