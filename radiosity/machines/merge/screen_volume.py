"""Screen volume: the faces of tetrahedra on the screen, and their boxes."""

from typing import NamedTuple

import numpy as np

from golden.base.errors import InputError
from radiosity.machines.merge.tetrahedra import Tetrahedra

__all__ = ["ScreenVolume", "drawn_direction", "view_volume"]


class ScreenVolume(NamedTuple):
    """N faces of a volume on a screen, seen along parallel rays.

    Parameters
    ----------
    points
        V x 3 float64: x to the right, y down and z away, all in pixels.
    values
        V float64.
    faces, sides
        As in `Tetrahedra`.
    boxes
        N x 4 int64: first x, first y, last x and last y of the pixels that each face touches.
    width, height
        Pixels of the screen.
    """

    points: np.ndarray
    values: np.ndarray
    faces: np.ndarray
    sides: np.ndarray
    boxes: np.ndarray
    width: int
    height: int


def drawn_direction(seed: int) -> np.ndarray:
    """3 float64: a direction of view, down on a volume from any side."""
    around, height = np.random.default_rng([seed, 1]).uniform((0, 0.15), (2 * np.pi, 0.85))
    return -np.array([np.cos(around) * np.sqrt(1 - height**2), np.sin(around) * np.sqrt(1 - height**2), height])


def view_volume(volume: Tetrahedra, direction: np.ndarray, width: int, height: int) -> ScreenVolume:
    """A volume seen along ``direction``, as large as the screen allows, with the z axis upwards.

    Parameters
    ----------
    volume
        The cells.
    direction
        3 float64, not along the z axis.
    width, height
        Pixels of the screen, at least 3: one at each edge is left free.

    Raises
    ------
    InputError
        They are fewer.
    """
    for name, value in (("Width", width), ("Height", height)):
        if value < 3:
            raise InputError(f"merge: {name} must be at least 3 for a volume, not {value!r}", parameter=name)
    forward = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    seen = volume.points @ np.stack([right, -np.cross(right, forward), forward], axis=1)
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = min((width - 2) / (high[0] - low[0]), (height - 2) / (high[1] - low[1]))
    middle = (low + high) / 2
    points = (seen - middle) * scale + (width / 2 - 0.5, height / 2 - 0.5, 0)
    at = points[volume.faces]
    boxes = np.concatenate([np.floor(at[:, :, :2].min(axis=1)), np.floor(at[:, :, :2].max(axis=1))], axis=1)
    boxes = np.clip(boxes, 0, (width - 1, height - 1) * 2).astype(np.int64)
    return ScreenVolume(points, volume.values, volume.faces, volume.sides, boxes, width, height)
