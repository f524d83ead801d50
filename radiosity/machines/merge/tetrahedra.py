"""Tetrahedra: curvilinear grids cut into cells with four corners, and the distinct triangles between these."""

from typing import NamedTuple

import numpy as np

from golden.base.errors import InputError

__all__ = ["Tetrahedra", "blunt_fin", "cut_grid"]

_FACES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))
# Corners of a hexahedron by bits: 1 for i, 2 for j, 4 for k. The first cell is inside, the others cut a corner off.
_CUT = np.array([(0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 3, 6), (4, 0, 5, 6), (7, 3, 5, 6)])


class Tetrahedra(NamedTuple):
    """A volume of T cells with N distinct faces.

    Parameters
    ----------
    points
        V x 3 float64.
    values
        V float64, 0 to 1.
    cells
        T x 4 int64: points.
    faces
        N x 3 int64: points in ascending order.
    sides
        N x 2 int64: the cells on both sides; of an exterior face the second is -1.
    """

    points: np.ndarray
    values: np.ndarray
    cells: np.ndarray
    faces: np.ndarray
    sides: np.ndarray


def cut_grid(points: np.ndarray, values: np.ndarray) -> Tetrahedra:
    """Cut each hexahedron of a grid into five tetrahedra, those of neighbours in mirrored order so that faces match.

    Parameters
    ----------
    points
        I x J x K x 3 float64, at least 2 along each side.
    values
        I x J x K float64.

    Source: Kurc 1997, section 6.2.
    """
    sides = points.shape[:3]
    number = np.arange(np.prod(sides)).reshape(sides)
    corner = np.arange(8)
    low = np.stack(np.meshgrid(*(np.arange(side - 1) for side in sides), indexing="ij"), axis=-1).reshape(-1, 3)
    flip = 7 * (low.sum(axis=1) % 2)
    at = low[:, None] + (corner[:, None] >> np.arange(3) & 1)
    hexahedra = number[at[:, :, 0], at[:, :, 1], at[:, :, 2]]
    # All bits of a corner flip in every second hexahedron.
    cells = np.take_along_axis(hexahedra[:, None], _CUT[None] ^ flip[:, None, None], axis=2).reshape(-1, 4)
    corners = np.sort(cells[:, np.array(_FACES)].reshape(-1, 3), axis=1)
    count = number.size
    _, first, inverse, times = np.unique((corners[:, 0] * count + corners[:, 1]) * count + corners[:, 2],
                                         return_index=True, return_inverse=True, return_counts=True)
    order = np.argsort(inverse, kind="stable")
    start = np.cumsum(times) - times
    both = np.stack([order[start] // 4, np.where(times == 2, order[start + times - 1] // 4, -1)], axis=1)
    return Tetrahedra(points.reshape(-1, 3), values.ravel(), cells, corners[first], both)


def blunt_fin(sides: tuple[int, int, int] = (40, 32, 32), *, seed: int = 0) -> Tetrahedra:
    """The flow around the blunt front of a fin on a plate: a stand-in for the data set of that name.

    Lines of the grid follow half of the fin's outline, from its front around the nose to the rear; layers grow from
    the fin outwards and from the plate upwards, each thicker than the last one by a drawn factor.

    Parameters
    ----------
    sides
        Points along the outline, outwards and upwards.
    seed
        Draws the nose, the extents, the growth of layers and the flow.

    Raises
    ------
    InputError
        A side has less than 2 points or more than 128, or the seed is below 0.
    """
    if len(sides) != 3 or min(sides) < 2 or max(sides) > 128:
        raise InputError(f"volume: Grid must have 2 to 128 points along each side, not {sides!r}", parameter="grid")
    if seed < 0:
        raise InputError(f"volume: Seed must be at least 0, not {seed!r}", parameter="seed")
    rng = np.random.default_rng(seed)
    nose, rear, reach, height = rng.uniform((0.4, 3, 3, 2.5), (0.7, 5, 5, 4))
    grow_out, grow_up = rng.uniform(1.06, 1.16, 2)
    along, out, up = (np.arange(side) for side in sides)
    turn = max(sides[0] // 2, 1)
    angle = np.pi / 2 * np.minimum(along / turn, 1)
    behind = rear * (np.maximum(along - turn, 0) / max(sides[0] - 1 - turn, 1))**1.3
    normal = np.stack([-np.cos(angle), np.sin(angle)], axis=1)
    surface = nose * normal + np.stack([behind, np.zeros_like(behind)], axis=1)
    distance = reach * _layers(out, grow_out)
    # The grid is wider at the side than in front.
    plane = surface[:, None] + normal[:, None] * (distance[:, None] * (0.6 + 0.4 * (angle / (np.pi / 2))))[
        ..., None].transpose(1, 0, 2)
    level = height * _layers(up, grow_up)
    points = np.concatenate([np.repeat(plane[:, :, None], sides[2], axis=2),
                             np.broadcast_to(level[None, None, :, None], (*sides, 1))], axis=3)
    shock, wave, phase = rng.uniform((0.8, 1, 0), (1.6, 3, 2 * np.pi))
    from_nose = np.linalg.norm(points[..., :2], axis=3) - nose
    layer = np.exp(-points[..., 2] / (0.15 * height))
    values = 0.7 / (1 + np.exp(4 * (from_nose - shock))) + 0.2 * layer + 0.1 * np.sin(
        wave * (points[..., 0] + points[..., 2]) + phase)**2
    return cut_grid(points, np.clip(values, 0, 1))


def _layers(number, growth):
    """0 to 1, with steps that grow."""
    steps = growth**number - 1
    return steps / steps[-1]
