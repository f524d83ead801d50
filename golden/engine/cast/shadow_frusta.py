"""Shadow rays as frusta: the host's part of casting them in the machine's integers.

All rays of a frustum leave one point of a light within a sixth of the sphere. A ray ends just in front of the plane in
which its shaded point lies.

Source: Shen 1993, section 2.5; docs/exactness.md, Shadow rays.
"""

from collections.abc import Iterator

import numpy as np

from golden.cast.shadow_rays import ShadowRays
from golden.engine.config import Numbers
from golden.engine.frustum.shadow_record import ShadowRecord, position, shadow_record
from golden.engine.icu.inverse_distance import encode
from golden.engine.scene.g_coordinates import GCoordinates

__all__ = ["LEAST", "MOST_BITS", "shadow_ends", "shadow_frusta"]

# Rays of a frustum, at least. Its grid has 2^FEWEST_BITS to 2^MOST_BITS positions an axis. A frustum takes the machine
# as long as so many positions of a grid.
LEAST = 16
FEWEST_BITS, MOST_BITS = 4, 8
FRUSTUM = 1 << 13
# Shells as a share of the scene's longest side.
SHELL = 1 / 8
# Axes of the six sixths of the sphere: forward along +x, +y, +z, -x, -y, -z.
AXES = np.array([[[0, 1, 0], [0, 0, 1], [1, 0, 0]], [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
                 [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
                 [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 0], [1, 0, 0], [0, 0, -1]]], dtype=np.float64)


def shadow_frusta(rays: ShadowRays, coordinates: GCoordinates, *,
                  least: int = LEAST) -> Iterator[tuple[np.ndarray, ShadowRecord, np.ndarray]]:
    """The frusta of shadow rays; rays that are in none are too few for one, or have no length.

    A ray's direction and end depend on it alone, so what blocks it does not depend on the other rays of its frustum.

    Parameters
    ----------
    rays, coordinates
        The rays, and the coordinates of the scene.
    least
        Rays of a frustum, at least; more from a light far from the scene, for the grid rays of the shells before it.
        With 1 every ray with a length is in one.

    Yields
    ------
    tuple
        The numbers of a frustum's rays, the frustum, and their numbers in it.
    """
    origins = coordinates.integers(rays.points)
    offset = (rays.targets - coordinates.points(origins)[rays.light]) * coordinates.scale
    along = np.argmax(np.abs(offset), axis=1)
    part = 6 * rays.light + along + 3 * (np.take_along_axis(offset, along[:, None], axis=1)[:, 0] < 0)
    # A target at the light's very point has no direction.
    away = np.flatnonzero(offset.any(axis=1))
    order = away[np.argsort(part[away], kind="stable")]
    enough = _least(least, rays.points, coordinates.bounds)
    for rows in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
        if not len(rows) or len(rows) < enough[rays.light[rows[0]]]:
            continue
        light, sixth = divmod(int(part[rows[0]]), 6)
        slopes, end = _encoded(offset[rows] @ AXES[sixth].T, rays.normals[rows] @ AXES[sixth].T, coordinates.numbers)
        for these, bits in _apart(slopes, coordinates.numbers, enough[light]):
            record, number = shadow_record(
                coordinates, origins[light], AXES[sixth], bits, slopes=slopes[these], end=end[these],
                source=int(rays.surfaces[light]))
            yield rows[these], record, number


def shadow_ends(directions: np.ndarray, offset: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Inverse distances, K float64, just in front of the planes with these normals through these offsets, K x 3 each.

    The margin exceeds the rounding of a patch in that plane, see docs/exactness.md.

    Parameters
    ----------
    directions
        K x 3 float64 in the R frame.
    """
    height = np.abs(np.einsum("ki,ki->k", normal, offset))
    along = np.abs(np.einsum("ki,ki->k", normal, directions))
    with np.errstate(divide="ignore", invalid="ignore"):
        steepness = np.linalg.norm(normal, axis=1) / height
        inverse = along / height
    ends = inverse * (1 + 2.0**-18 + 2.0**-19 * steepness) + 2.0**-20 * steepness + 2.0**-38
    return np.where(np.isfinite(ends), ends, np.inf)


def _least(least, points, bounds):
    """Rays that make up for a frustum from each point of a light, at least; see `shadow_frusta`."""
    outside = np.maximum(np.maximum(bounds[0] - points, points - bounds[1]), 0)
    shells = np.linalg.norm(outside, axis=1) / np.ptp(bounds, axis=0).max() / SHELL
    # A screen with slopes from -1 to 1 has 8 s^2 grid rays in shell s.
    return least + np.floor((least - 1) * 8 / 3 * shells**3 / FRUSTUM)


def _encoded(offset: np.ndarray, normal: np.ndarray, numbers: Numbers):
    """Slopes and stored ends of rays to offsets in the R frame."""
    one = 1 << numbers.direction_fraction
    slopes = np.clip(np.rint(offset[:, :2] / offset[:, 2:] * one), -one, one - 1).astype(np.int64)
    directions = np.concatenate([slopes / one, np.ones((len(slopes), 1))], axis=1)
    mantissa, exponent = np.frexp(np.minimum(shadow_ends(directions, offset, normal), 2.0**40))
    return slopes, encode(np.ceil(mantissa * 2.0**30).astype(np.int64), exponent - 30, numbers, up=True)


def _apart(slopes, numbers, least):
    """Parts of K rays in which no two have the same position, and the bits of their grids; none is too small.

    A part has the grid with the most rays for its cycles. What remains of it is divided again.
    """
    left = np.arange(len(slopes))
    while len(left) >= least:
        alone = {bits: np.unique(position(slopes[left], bits, numbers), return_index=True)[1]
                 for bits in range(FEWEST_BITS, MOST_BITS + 1)}
        bits = max(alone, key=lambda bits: len(alone[bits]) / (FRUSTUM + 4**bits))
        if len(alone[bits]) < least:
            return
        yield left[np.sort(alone[bits])], bits
        left = np.delete(left, alone[bits])
