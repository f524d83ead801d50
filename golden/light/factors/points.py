"""Points on patches and directions above them, from sequences that fill their domain evenly."""

import numpy as np

from golden.light.sampling import mix, uniform

__all__ = ["REPLICATES", "cosine_directions", "points_on", "sequence", "weighted_points_on"]

# Independent shifts of one sequence: the variance of their results estimates that of the mean.
REPLICATES = 16

# The root of x^5 = x + 1: multiples of its inverse powers fill the four-dimensional cube most evenly.
_ROOT = 1.1673039782614187
_STEP = _ROOT ** -np.arange(1, 5)


def sequence(uses: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Points of [0, 1)^4: number k belongs to replicate k modulo `REPLICATES`.

    Parameters
    ----------
    uses
        K uint64: hashes of what the points are for (`golden.light.sampling.mix`).
    number
        K int: numbers within the use; points 0 to n - 1 fill the cube evenly for each n.

    Returns
    -------
    K x 4 float64.

    Source: M. Roberts, The unreasonable effectiveness of quasirandom sequences (2018).
    """
    turn, replicate = np.divmod(np.asarray(number), REPLICATES)
    state = mix(uses, replicate)
    shift = np.stack([uniform(state, dimension) for dimension in range(4)], axis=-1)
    return (shift + turn[..., None] * _STEP) % 1.0


def points_on(vertices: np.ndarray, triangle: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Points that are uniform by area on patches, K x 3, for uniform u and v."""
    # Of the triangles (0, 1, 2) and (0, 2, 3) the first one has the lower part of u.
    a, b, c, d = (vertices[:, k] for k in range(4))
    first = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    share = np.where(triangle, 1.0, first / (first + np.linalg.norm(np.cross(c - a, d - a), axis=1)))
    lower = u < share
    along = np.where(lower, u / share, (u - share) / np.where(lower, 1.0, 1 - share))
    side = np.sqrt(v)
    start, end = np.where(lower[:, None], b, c), np.where(lower[:, None], c, d)
    return a + side[:, None] * (start - a + along[:, None] * (end - start))


def weighted_points_on(vertices: np.ndarray, triangle: np.ndarray, u: np.ndarray, v: np.ndarray):
    """Points on patches by a smooth map of the unit square, K x 3, and their area vectors, K x 3."""
    # A triangle's two last vertices are one, to which v = 1 leads: the root makes its points uniform.
    root = np.where(triangle, np.sqrt(1 - v), 0.5)
    v = np.where(triangle, 1 - root, v)
    a, b, c, d = (vertices[:, k] for k in range(4))
    u, v = u[:, None], v[:, None]
    low, high = a + u * (b - a), d + u * (c - d)
    along_u = (1 - v) * (b - a) + v * (c - d)
    return low + v * (high - low), np.cross(along_u, high - low) * (0.5 / root)[:, None]


def cosine_directions(frames: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Directions distributed by the cosine with the third axis, K x 3, for uniform u and v; frames are K x 3 x 3."""
    angle, sine = 2 * np.pi * u, np.sqrt(v)
    local = np.stack([sine * np.cos(angle), sine * np.sin(angle), np.sqrt(1 - v)], axis=1)
    return np.einsum("rk,rki->ri", local, frames)
