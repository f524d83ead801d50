"""M. Newell's teapot: 32 bicubic Bezier patches, with the flattened proportions and the bottom in common use."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import bezier, square

__all__ = ["CONTROL_POINTS", "teapot"]

# Profiles of the parts that turn around the z axis: distance from it and height, along the outside.
RIM = ((1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4))
BODY = (((1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)),
        ((2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)))
LID = (((0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)),
       ((0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)))
BOTTOM = ((1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0))

ARC = 0.56
"""Where the tangents of a quarter circle of radius 1 end; 0.5523 would be nearer to a circle."""

KNOB_ARC = 0.5625
"""The same for the widest row of the lid's grip (0.45 of 0.8)."""

# Cross sections of handle and spout: x and z on the one and on the other side of the plane y = 0, and half the width.
HANDLE = (((-1.6, 2.025, -1.5, 2.25, 0.3), (-2.3, 2.025, -2.5, 2.25, 0.3),
           (-2.7, 2.025, -3.0, 2.25, 0.3), (-2.7, 1.8, -3.0, 1.8, 0.3)),
          ((-2.7, 1.8, -3.0, 1.8, 0.3), (-2.7, 1.575, -3.0, 1.35, 0.3),
           (-2.5, 1.125, -2.65, 0.9375, 0.3), (-2.0, 0.9, -1.9, 0.6, 0.3)))
SPOUT = (((1.7, 1.425, 1.7, 0.6, 0.66), (2.6, 1.425, 3.1, 0.825, 0.66),
          (2.3, 2.1, 2.4, 2.025, 0.25), (2.7, 2.4, 3.3, 2.4, 0.25)),
         ((2.7, 2.4, 3.3, 2.4, 0.25), (2.8, 2.475, 3.525, 2.49375, 0.25),
          (2.9, 2.475, 3.45, 2.5125, 0.15), (2.8, 2.4, 3.2, 2.4, 0.15)))


def _turned(profile) -> np.ndarray:
    """4 x 4 x 4 x 3: the patches of the four quarter turns; first index along the profile, second against the clock."""
    quarters = np.empty((4, 4, 4, 3))
    for row, (radius, height) in enumerate(profile):
        arc = KNOB_ARC if (radius, height) == LID[0][1] else ARC
        x, y = radius * np.array((1, 1, arc, 0)), radius * np.array((0, arc, 1, 1))
        for quarter, (east, north) in enumerate(((x, y), (-y, x), (-x, -y), (y, -x))):
            quarters[quarter, row] = np.stack((east, north, np.full(4, height)), axis=1)
    return quarters


def _mirrored(sections) -> np.ndarray:
    """2 x 4 x 4 x 3: the patches on both sides of the plane y = 0; first index along the tube, second around it."""
    halves = np.empty((2, 4, 4, 3))
    for row, (x, z, far_x, far_z, width) in enumerate(sections):
        half = np.array(((x, 0, z), (x, -width, z), (far_x, -width, far_z), (far_x, 0, far_z)))
        halves[:, row] = half, half[::-1] * (1, -1, 1)
    return halves


def _control_points() -> np.ndarray:
    upper = [_turned(part) for part in (RIM, *BODY)]
    tubes = [_mirrored(part).swapaxes(1, 2) for part in (*HANDLE, *SPOUT)]
    ends = [_turned(part) for part in (*LID, BOTTOM)]
    # Products are rounded to the decimals in which the points are published; adding zero turns -0 into 0.
    return np.round(np.concatenate((*upper, *tubes, *ends)), 9) + 0.0


CONTROL_POINTS = _control_points()
"""32 x 4 x 4 x 3: rim 4, body 8, handle 4, spout 4, lid 8, bottom 4. Fronts, where the first index turns to the second
counter-clockwise, are outside. The gap between lid and rim is Newell's."""
CONTROL_POINTS.setflags(write=False)


def teapot(size: int) -> Scene:
    """The teapot on a board of ``size`` x ``size`` squares, each Bezier patch cut into as many cells."""
    builder = SceneBuilder("teapot")
    glaze = Material(name="glaze", diffuse=(0.62, 0.58, 0.5), specular=(0.07, 0.07, 0.07))
    builder.add(bezier(CONTROL_POINTS, cuts=size), glaze, smooth=True)
    board = square((0, 0, 0), 12, cuts=size)
    odd = np.add.outer(np.arange(size), np.arange(size)).ravel() % 2 == 1
    for squares, name, shade in ((board[odd], "dark square", 0.25), (board[~odd], "light square", 0.7)):
        material = Material(name=name, diffuse=(shade, 0.95 * shade, 0.85 * shade), specular=(0.04, 0.04, 0.04))
        builder.add(squares, material, surface=0)
    lamp = square((-3.0, -4.0, 9.0), 4.0, facing=(3.0, 4.0, -8.0), cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(16.0, 15.5, 14.5)), surface=0)
    return builder.build(camera=Camera(eye=(2.6, -8.6, 5.4), target=(0.35, 0, 1.35), fov=41),
                         background=(0.45, 0.5, 0.6))
