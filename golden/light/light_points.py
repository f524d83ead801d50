"""Points on lights, drawn by area."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["by_area", "net", "net_points"]


@compiled
def by_area(vertices: np.ndarray, is_triangle: np.ndarray, light: np.ndarray, origin: np.ndarray, u: np.ndarray,
            v: np.ndarray, toward: np.ndarray, measure: np.ndarray) -> None:
    """Vectors to points of lights, and the solid angle per unit square there.

    The point of a quadrilateral is bilinear in (u, v). Rows of a triangle shrink towards its repeated corner: longer
    rows get a larger part of the square.

    Parameters
    ----------
    vertices, is_triangle
        L x 4 x 3 corners of the lights, and whether the fourth repeats the third.
    light
        K numbers of lights.
    origin
        K x 3 points.
    u, v
        K numbers of the unit square.
    toward, measure
        K x 3 and K: the results.
    """
    for k in range(len(light)):
        corner = vertices[light[k]]
        x, y = u[k], v[k]
        if is_triangle[light[k]]:
            y = 1 - np.sqrt(1 - y)
            ax, ay, az = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
            bx, by, bz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
            half = 0.5
        else:
            ax = (1 - y) * (corner[1, 0] - corner[0, 0]) + y * (corner[2, 0] - corner[3, 0])
            ay = (1 - y) * (corner[1, 1] - corner[0, 1]) + y * (corner[2, 1] - corner[3, 1])
            az = (1 - y) * (corner[1, 2] - corner[0, 2]) + y * (corner[2, 2] - corner[3, 2])
            bx = (1 - x) * (corner[3, 0] - corner[0, 0]) + x * (corner[2, 0] - corner[1, 0])
            by = (1 - x) * (corner[3, 1] - corner[0, 1]) + x * (corner[2, 1] - corner[1, 1])
            bz = (1 - x) * (corner[3, 2] - corner[0, 2]) + x * (corner[2, 2] - corner[1, 2])
            half = 1.0
        tx, ty, tz = (_toward(corner, 0, x, y, origin[k, 0]), _toward(corner, 1, x, y, origin[k, 1]),
                      _toward(corner, 2, x, y, origin[k, 2]))
        toward[k, 0], toward[k, 1], toward[k, 2] = tx, ty, tz
        volume = (ay * bz - az * by) * tx + (az * bx - ax * bz) * ty + (ax * by - ay * bx) * tz
        distance2 = tx * tx + ty * ty + tz * tz
        measure[k] = half * np.abs(volume) / (distance2 * np.sqrt(distance2))


@compiled
def _toward(corner, axis, x, y, origin):
    return (1 - y) * ((1 - x) * (corner[0, axis] - origin) + x * (corner[1, axis] - origin)) + y * (
        (1 - x) * (corner[3, axis] - origin) + x * (corner[2, axis] - origin))


def net(u: np.ndarray, v: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The points of a net in whose squares the points (u, v) of the unit square are: their numbers, and their x and y.

    The net is Hammersley's, of 4^``bits`` points: each of 2^``bits`` x 2^``bits`` squares has one of them, and so has
    each strip of equal area along x or y.
    """
    side = 1 << bits
    a, b = (np.minimum((value * side).astype(np.int64), side - 1) for value in (u, v))
    reverse = np.array([int(f"{number:0{bits}b}"[::-1], 2) for number in range(side)])
    return a * side + b, (a + (reverse[b] + 0.5) / side) / side, (b + (reverse[a] + 0.5) / side) / side


def net_points(vertices: np.ndarray, is_triangle: np.ndarray, bits: int) -> np.ndarray:
    """The points of the net on each of L lights, L 4^``bits`` x 3, as `by_area` draws them."""
    number = np.arange(4**bits)
    _, x, y = net((number >> bits) / 2.0**bits, (number % (1 << bits)) / 2.0**bits, bits)
    light = np.repeat(np.arange(len(vertices)), len(number))
    points, measure = np.empty((len(light), 3)), np.empty(len(light))
    # The origin is outside the lights' planes or not: the measure is not used.
    by_area(vertices, is_triangle, light, np.zeros((len(light), 3)), np.tile(x, len(vertices)),
            np.tile(y, len(vertices)), points, measure)
    return points
