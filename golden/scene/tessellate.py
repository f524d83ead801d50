"""Curved surfaces as patches.

All functions return N x 4 x 3 float64 patches, fronts outwards, a triangle repeating its last vertex. Corners where
patches meet have the same coordinates, bit for bit.
"""

from functools import lru_cache

import numpy as np

from golden.base.errors import InputError
from golden.scene.polygons import split_nonplanar

__all__ = ["bezier", "frustum", "revolution", "sphere", "square"]

PLANAR = 1e-12
"""Largest distance of a corner from its quad's plane, as a share of the largest coordinate."""


def _across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that form a right-handed orthogonal frame with the axis."""
    least = np.zeros(3)
    least[np.abs(axis).argmin()] = 1.0
    side = np.cross(least, axis)
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    return side, other / np.linalg.norm(other)


def square(center, side: float, *, facing=(0.0, 0.0, 1.0), cuts: int = 1) -> np.ndarray:
    """A square as ``cuts`` x ``cuts`` patches, with its front towards the direction ``facing``.

    Where that is along an axis of coordinates, the sides are along the others.
    """
    across, along = _across(np.asarray(facing, dtype=np.float64))
    steps = (side * (np.arange(cuts + 1) / cuts - 0.5))[:, None]
    return _cells(center + (steps * across)[:, None] + (steps * along)).reshape(-1, 4, 3)


def _cells(points: np.ndarray) -> np.ndarray:
    """... x m x n x 3 grid points to ... x m-1 x n-1 x 4 x 3 quads, wound from the first index to the second."""
    return np.stack((points[..., :-1, :-1, :], points[..., 1:, :-1, :],
                     points[..., 1:, 1:, :], points[..., :-1, 1:, :]), axis=-2)


def revolution(profile, *, segments: int = 16) -> np.ndarray:
    """The surface of revolution of a profile around the z axis.

    A quad between two parallel circles is an isosceles trapezoid, hence planar; at the axis there are triangles.

    Parameters
    ----------
    profile
        K x 2: distance from the axis and height of its points, no two neighbours at one point or both on the axis.
        Where it climbs, the front points away from the axis.
    segments
        Patches around the axis.

    Returns
    -------
    ndarray
        ``(K - 1) * segments`` patches, band after band along the profile.
    """
    profile = np.asarray(profile, dtype=np.float64)
    on_axis = profile[:, 0] == 0
    angle = 2 * np.pi * np.arange(segments) / segments
    rings = np.empty((len(profile), segments + 1, 3))
    # Adding zero makes -0 0, so that equal corners have equal bytes.
    rings[:, :-1, 0] = profile[:, :1] * np.cos(angle) + 0.0
    rings[:, :-1, 1] = profile[:, :1] * np.sin(angle) + 0.0
    rings[:, :-1, 2] = profile[:, 1:]
    rings[:, -1] = rings[:, 0]
    bands = _cells(rings)[..., [0, 3, 2, 1], :]
    bands[on_axis[:-1]] = bands[on_axis[:-1]][:, :, [0, 2, 3, 3]]
    return bands.reshape(-1, 4, 3)


@lru_cache(maxsize=64)
def _unit_sphere(segments: int) -> np.ndarray:
    bands = max(2, segments // 2)
    polar = np.pi * np.arange(1, bands) / bands
    profile = np.stack((np.sin(polar), -np.cos(polar)), axis=1)
    patches = revolution([(0.0, -1.0), *profile, (0.0, 1.0)], segments=segments)
    patches.setflags(write=False)
    return patches


def sphere(center, radius: float, *, segments: int = 16) -> np.ndarray:
    """A sphere as ``segments`` meridians and half as many bands, with its poles along z and its corners on the sphere.

    Raises
    ------
    InputError
        The radius is not a finite value above 0.
    """
    if not (np.isfinite(radius) and radius > 0):
        raise InputError(f"Radius must be a finite value above 0, not {radius!r}")
    return np.asarray(center, dtype=np.float64) + radius * _unit_sphere(segments)


def frustum(base, apex, base_radius: float, apex_radius: float, *, segments: int = 16) -> np.ndarray:
    """The side of a cylinder, cone or frustum of a cone between two points of its axis, ``segments`` patches.

    Parameters
    ----------
    base, apex
        Centers of the two ends.
    base_radius, apex_radius
        Radii there; one of them may be 0.

    Raises
    ------
    InputError
        The ends coincide, a radius is negative or not finite, or both are 0.
    """
    base, apex = np.asarray(base, dtype=np.float64), np.asarray(apex, dtype=np.float64)
    for name, radius in (("Base radius", base_radius), ("Apex radius", apex_radius)):
        if not (np.isfinite(radius) and radius >= 0):
            raise InputError(f"{name} must be a finite value of at least 0, not {radius!r}")
    if base_radius == 0 and apex_radius == 0:
        raise InputError("Base radius must be above 0 where the apex radius is 0, not 0")
    axis = apex - base
    if not np.linalg.norm(axis) > 0:
        raise InputError(f"Apex must be away from the base, not at {tuple(base.tolist())!r} as well")
    local = revolution([(base_radius, 0.0), (apex_radius, 1.0)], segments=segments)
    side, other = _across(axis)
    return base + local[..., :1] * side + local[..., 1:2] * other + local[..., 2:] * axis


def bezier(control, *, cuts: int) -> np.ndarray:
    """Bicubic Bezier patches as flat patches.

    A border depends on its own control points only, and not on their direction, so neighbours that share them share
    the corners, bit for bit.

    Parameters
    ----------
    control
        4 x 4 x 3 or M x 4 x 4 x 3 control points; the front is where the first index winds to the second
        counter-clockwise.
    cuts
        Cells along a side.

    Returns
    -------
    ndarray
        At most ``2 * cuts**2`` patches for each Bezier patch: a cell that is planar is one quad, another is cut into
        two triangles, one at a collapsed border is one triangle, one without area is omitted.
    """
    points = _bezier_points(np.asarray(control, dtype=np.float64).reshape(-1, 4, 4, 3), cuts)
    quads = _without_collapsed_sides(_cells(points).reshape(-1, 4, 3))
    patches, _ = split_nonplanar(_without_twisted(quads))
    areas = np.linalg.norm(np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1]), axis=1)
    return patches[areas > PLANAR * np.ptp(points) ** 2]


def _bezier_points(control: np.ndarray, cuts: int) -> np.ndarray:
    """M x 4 x 4 x 3 to M x (cuts + 1) x (cuts + 1) x 3 points of the surfaces."""
    here = np.arange(cuts + 1) / cuts
    there = here[::-1]
    weights = np.stack((there * there * there, 3 * (here * (there * there)),
                        3 * (there * (here * here)), here * here * here))[:, :, None, None]
    # Summed in pairs that a reversal of the points only swaps.
    rows = control[:, :, None]
    rows = ((rows[:, 0] * weights[0] + rows[:, 3] * weights[3])
            + (rows[:, 1] * weights[1] + rows[:, 2] * weights[2]))
    weights = weights.swapaxes(1, 2)
    columns = rows[:, :, :, None]
    points = ((columns[:, :, 0] * weights[0] + columns[:, :, 3] * weights[3])
              + (columns[:, :, 1] * weights[1] + columns[:, :, 2] * weights[2]))
    for border, name in ((control[:, 0], np.s_[:, 0]), (control[:, 3], np.s_[:, -1]),
                         (control[:, :, 0], np.s_[:, :, 0]), (control[:, :, 3], np.s_[:, :, -1])):
        collapsed = (border == border[:, :1]).all(axis=(1, 2))
        points[name][collapsed] = border[collapsed, :1]
    return points + 0.0


def _without_collapsed_sides(quads: np.ndarray) -> np.ndarray:
    """Makes quads of three different corners triangles; drops those of fewer."""
    equal = (quads == np.roll(quads, -1, axis=1)).all(axis=2)
    crossed = (quads[:, :2] == quads[:, 2:]).all(axis=2).any(axis=1)
    kept = (equal.sum(axis=1) < 2) & ~crossed
    quads, equal = quads[kept].copy(), equal[kept]
    for side, order in enumerate(([0, 2, 3, 3], [0, 1, 3, 3], [0, 1, 2, 2], [0, 1, 2, 2])):
        quads[equal[:, side]] = quads[equal[:, side]][:, order]
    return quads


def _without_twisted(quads: np.ndarray) -> np.ndarray:
    """Cuts quads that are not planar but for rounding along their shorter diagonal."""
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    heights = np.abs(np.einsum("ij,ij->i", quads[:, 1] - quads[:, 0], normals))
    twisted = heights > PLANAR * np.abs(quads).max(axis=(1, 2)) * lengths
    diagonals = np.linalg.norm(quads[:, [2, 3]] - quads[:, [0, 1]], axis=2)
    turned = np.where((diagonals[:, 1] < diagonals[:, 0])[:, None, None], np.roll(quads, -1, axis=1), quads)
    first = np.where(twisted[:, None, None], turned[:, [0, 1, 2, 2]], quads)
    both = np.stack((first, turned[:, [0, 2, 3, 3]]), axis=1)
    return both[np.stack((np.ones_like(twisted), twisted), axis=1)]
