"""Stand-ins for the source's lost scenes, with its numbers of objects and what it says of them."""

from collections.abc import Callable

import numpy as np

from radiosity.machines.torus.torus_scene import TorusScene

__all__ = ["TORUS_SCENES", "barroom367", "face954", "spheres40"]

_SLOPE = 0.4


def _scene(name, corners, counts, colours, mirrors, lights, *, eye, target) -> TorusScene:
    """Objects and lights turned into the coordinates of an eye that looks at a target; height is the second axis."""
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross((0.0, 1.0, 0.0), forward)
    right = right / np.linalg.norm(right)
    axes = np.array([right, np.cross(forward, right), forward])
    is_sphere = np.asarray(counts) == 0
    corners = np.array(corners, dtype=np.float64)
    turned = (corners - eye) @ axes.T
    # The second row of a sphere is no point.
    turned[is_sphere, 1:] = corners[is_sphere, 1:]
    lights = np.array(lights, dtype=np.float64)
    lights[:, :3] = (lights[:, :3] - eye) @ axes.T
    colours, mirrors = np.array(colours, dtype=np.float64), np.array(mirrors, dtype=np.float64)
    coefficients = np.concatenate([0.15 * colours, colours, np.repeat(mirrors[:, None], 3, axis=1),
                                   np.zeros((len(colours), 3)), np.ones((len(colours), 1))], axis=1)
    return TorusScene(name=name, corners=turned, counts=np.array(counts), coefficients=coefficients, lights=lights,
                      slope=_SLOPE)


def spheres40(seed: int = 0) -> TorusScene:
    """40 mirroring spheres in a cube of side 2, their centres and radii drawn; two lights."""
    rng = np.random.default_rng(seed)
    corners = np.zeros((40, 4, 3))
    corners[:, 0] = rng.uniform(-0.9, 0.9, (40, 3))
    corners[:, 1, 0] = rng.uniform(0.08, 0.2, 40)
    return _scene("spheres40", corners, np.zeros(40, dtype=np.int64), rng.uniform(0.2, 0.6, (40, 3)), np.full(40, 0.4),
                  [[-3, 4, -4, 0.1, 0.6, 0.6, 0.6], [4, 3, -3, 0.1, 0.4, 0.4, 0.4]], eye=(0, 0, -3.5), target=(0, 0, 0))


def _box(low, high):
    """Six faces of a box."""
    (a, b, c), (x, y, z) = low, high
    return [[(a, b, c), (a, y, c), (x, y, c), (x, b, c)], [(a, b, z), (x, b, z), (x, y, z), (a, y, z)],
            [(a, b, c), (a, b, z), (a, y, z), (a, y, c)], [(x, b, c), (x, y, c), (x, y, z), (x, b, z)],
            [(a, b, c), (x, b, c), (x, b, z), (a, b, z)], [(a, y, c), (a, y, z), (x, y, z), (x, y, c)]]


def _prism(centre, radius, low, high, sides):
    """Sides and a top of triangles of an upright prism."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    x, z = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    found = [[(x[i], low, z[i]), (x[i], high, z[i]), (x[i + 1], high, z[i + 1]), (x[i + 1], low, z[i + 1])]
             for i in range(sides)]
    return found + [[(centre[0], high, centre[1]), (x[i], high, z[i]), (x[i + 1], high, z[i + 1]),
                      (x[i + 1], high, z[i + 1])] for i in range(sides)]


def _cone(centre, radius, low, high, sides):
    """A lampshade of triangles that meet in its apex."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    x, z = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    return [[(centre[0], high, centre[1]), (x[i + 1], low, z[i + 1]), (x[i], low, z[i]), (x[i], low, z[i])]
            for i in range(sides)]


def barroom367(seed: int = 0) -> TorusScene:
    """A corner of a room with a table, two stools and three conical lampshades of 78 triangles each: 367 polygons.

    Walls, table and stools: 3 walls, a table of a box on four legs (30), two stools of a prism of 14 sides on four legs
    (104 with their crossbars), less one hidden face. The seed draws where furniture and lamps are.
    """
    rng = np.random.default_rng(seed)
    walls = [[(-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)], [(-2, 0, 2), (-2, 3, 2), (2, 3, 2), (2, 0, 2)],
             [(2, 0, 2), (2, 3, 2), (2, 3, -2), (2, 0, -2)]]
    table, lamps, stools = rng.uniform(-0.3, 0.3, 2), [], []
    parts = _box((table[0] - 0.7, 0.95, table[1] - 0.5), (table[0] + 0.7, 1.0, table[1] + 0.5))
    for x in (-0.6, 0.6):
        for z in (-0.4, 0.4):
            at = np.add(table, (x, z))
            parts += _box((at[0] - 0.04, 0, at[1] - 0.04), (at[0] + 0.04, 0.95, at[1] + 0.04))
    for x in (-1.2, 1.2):
        at = np.add(table, (x, -0.2)) + rng.uniform(-0.15, 0.15, 2)
        stools += _prism(at, 0.25, 0.6, 0.68, 13)
        for turn in range(4):
            leg = at + 0.17 * np.array([np.cos(turn * np.pi / 2), np.sin(turn * np.pi / 2)])
            stools += _box((leg[0] - 0.03, 0, leg[1] - 0.03), (leg[0] + 0.03, 0.6, leg[1] + 0.03))
    for x in (-0.9, 0.0, 0.9):
        at = np.array([x, 0.4]) + rng.uniform(-0.2, 0.2, 2)
        lamps += _cone(at, 0.35, 1.9, 2.25, 78)
    corners = np.array(walls + parts + stools + lamps)
    counts = np.where((corners[:, 3] == corners[:, 2]).all(axis=1), 3, 4)
    colours = np.concatenate([np.full((3, 3), 0.6), np.tile([0.5, 0.3, 0.15], (len(parts) + len(stools), 1)),
                              np.tile([0.6, 0.5, 0.2], (len(lamps), 1))])
    mirrors = np.where(np.arange(len(corners)) == 3, 0.2, 0.0)
    return _scene("barroom367", corners, counts, colours, mirrors,
                  [[-1.5, 2.8, -1.5, 0.05, 0.6, 0.6, 0.6], [0.5, 2.8, -1.0, 0.05, 0.4, 0.4, 0.4]],
                  eye=(-4.2, 2.4, -4.6), target=(0.3, 1.2, 0.3))


def face954(seed: int = 0) -> TorusScene:
    """A relief of 954 triangles, denser in its middle: 53 columns by 9 rows of quadrilaterals, halved.

    The seed draws its hills. Columns and rows are narrow in the middle, where eyes, nose and mouth would be.
    """
    rng = np.random.default_rng(seed)
    columns, rows = 53, 9

    def dense(count):
        at = np.linspace(-1, 1, count + 1)
        return 0.35 * at + 0.65 * at ** 3

    x, y = np.meshgrid(dense(columns), 1.3 * dense(rows), indexing="ij")
    z = 0.5 * (x * x + y * y / 1.69)
    for _ in range(8):
        at, width = rng.uniform(-0.35, 0.35, 2), rng.uniform(0.08, 0.2)
        z = z + rng.uniform(-0.25, 0.15) * np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / width ** 2)
    points = np.stack([x, y, z], axis=2)
    one, two, three, four = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    corners = np.stack([one, two, three, three, one, three, four, four], axis=2).reshape(-1, 4, 3)
    return _scene("face954", corners, np.full(len(corners), 3), np.tile([0.7, 0.5, 0.4], (len(corners), 1)),
                  np.zeros(len(corners)), [[-3, 3, -4, 0.1, 0.7, 0.7, 0.7], [3, 1, -4, 0.1, 0.3, 0.3, 0.3]],
                  eye=(0, 0, -3.6), target=(0, 0, 0))


TORUS_SCENES: dict[str, Callable[..., TorusScene]] = {
    "spheres40": spheres40, "barroom367": barroom367, "face954": face954}
"""Generators by name; each takes a seed."""
