"""Screen triangles: the patches of a scene that face the camera, as triangles on the screen."""

from typing import NamedTuple

import numpy as np

from golden.scene.camera import Camera
from golden.scene.scene import Scene

__all__ = ["ScreenTriangles", "project_scene"]

# Nearest depth that is drawn, in view distances.
_NEAR = 1e-3


class ScreenTriangles(NamedTuple):
    """N triangles.

    Parameters
    ----------
    corners
        N x 3 x 3 float64: x to the right and y down in pixels, and a depth that is linear on the screen; the smallest
        one is nearest.
    colour
        N x 3 x 3 float64: red, green and blue of each corner, 0 to 255.
    dealt
        How many triangles the scene has, with those that are not drawn.
    """

    corners: np.ndarray
    colour: np.ndarray
    dealt: int


def project_scene(scene: Scene, camera: Camera, width: int, height: int) -> tuple[ScreenTriangles, np.ndarray]:
    """The triangles of all patches, culled, clipped and shaded; and of each the number of its triangle in the scene.

    A quadrilateral has two triangles. Those of the back of a one-sided patch are culled, and parts nearer than a
    thousandth of the view distance are clipped. A lamp at the eye lights each corner.

    Parameters
    ----------
    scene, camera
        What is seen, and from where.
    width, height
        Pixels of the screen.

    Source: Kurc 1997, sections 3.1 and 4.2.
    """
    eye = np.asarray(camera.eye)
    vertices = scene.vertices - eye
    patch = np.concatenate([np.arange(len(scene)), np.flatnonzero(~scene.is_triangle)])
    order = np.argsort(patch, kind="stable")
    triangles = np.concatenate([vertices[:, :3], vertices[~scene.is_triangle][:, [0, 2, 3]]])[order]
    patch = patch[order]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    faces = -np.einsum("ij,ij->i", normal, triangles[:, 0])
    is_seen = (faces > 0) | (scene.two_sided[patch] & (faces != 0))
    number = np.flatnonzero(is_seen)
    triangles, normal, patch = triangles[number], normal[number], patch[number]
    distance = np.linalg.norm(triangles, axis=2)
    cosine = np.abs(np.einsum("ij,ikj->ik", normal, triangles)) / (
        np.linalg.norm(normal, axis=1)[:, None] * np.maximum(distance, 1e-300))
    diffuse = scene.channels("diffuse")[patch] + scene.channels("emission")[patch]
    colour = 255 * np.minimum(0.1 + 0.9 * cosine[:, :, None] * np.clip(diffuse, 0, 1)[:, None], 1)
    view = triangles @ camera.axes.T
    view, colour, number = _clipped(view, colour, number, _NEAR * np.linalg.norm(np.subtract(camera.target, eye)))
    scale = height / (2 * np.tan(np.radians(camera.fov) / 2))
    corners = np.stack([(width - 1) / 2 + scale * view[:, :, 0] / view[:, :, 2],
                        (height - 1) / 2 - scale * view[:, :, 1] / view[:, :, 2], -1 / view[:, :, 2]], axis=2)
    return ScreenTriangles(corners, colour, len(is_seen)), number


def _clipped(view, colour, number, near):
    """Triangles with the parts beyond ``near``: whole ones, then one or two of each that is cut."""
    is_far = view[:, :, 2] > near
    count = is_far.sum(axis=1)
    found = [(view[count == 3], colour[count == 3], number[count == 3])]
    for far in (1, 2):
        cut = np.flatnonzero(count == far)
        # The corner that differs comes first.
        first = np.argmax(is_far[cut] == (far == 1), axis=1)
        turn = (first[:, None] + np.arange(3)) % 3
        both = np.concatenate([view, colour], axis=2)[cut[:, None], turn]
        share = (near - both[:, :1, 2]) / (both[:, 1:, 2] - both[:, :1, 2])
        edge = both[:, :1] + share[:, :, None] * (both[:, 1:] - both[:, :1])
        edge[:, :, 2] = near
        parts = [np.stack([both[:, 0], edge[:, 0], edge[:, 1]], axis=1)] if far == 1 else [
            np.stack([edge[:, 0], both[:, 1], both[:, 2]], axis=1),
            np.stack([edge[:, 0], both[:, 2], edge[:, 1]], axis=1)]
        found += [(one[:, :, :3], one[:, :, 3:], number[cut]) for one in parts]
    view, colour, number = map(np.concatenate, zip(*found, strict=True))
    order = np.argsort(number, kind="stable")
    return view[order], colour[order], number[order]
