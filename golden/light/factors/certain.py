"""Pairs of patches whose visibility geometry decides."""

import numpy as np

from golden.light.factors.sides import Sides

__all__ = ["TOUCH", "certain_shares"]

# Share of the scene's size by which a patch may enter the space between a pair and still count as touching it.
TOUCH = 2.0**-32

# Pairs times patches per block, which bounds memory.
_BLOCK = 1 << 17


def certain_shares(sides: Sides, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs nothing blocks, or one patch hides wholly.

    The segments between two convex patches fill their convex hull. A patch leaves it free if a plane separates
    them: its own, that of either patch, one of the axes', or one through an edge of the one patch and a corner of the
    other. It hides the pair if the patches are on the two sides of its plane and all segments between their corners
    pass through it: where other segments pass is the convex hull of where these do.

    Parameters
    ----------
    first, second
        P int: the sides of each pair.

    Returns
    -------
    P bool: decided; and P float64: 1 if seen wholly, 0 if hidden. A pair that is not decided may still be either.
    """
    patches = sides.scene
    decided, share = np.zeros(len(first), dtype=bool), np.ones(len(first))
    step = max(1, _BLOCK // len(patches))
    for start in range(0, len(first), step):
        rows = slice(start, start + step)
        decided[rows], share[rows] = _decide(sides, first[rows], second[rows])
    return decided, share


def _decide(sides, first, second):
    patches, touch = sides.scene, TOUCH * sides.scene.size
    ends = np.stack([sides.vertices[first], sides.vertices[second]], axis=1)
    offset = np.einsum("ij,ij->i", patches.normals, patches.centres)
    height = np.einsum("pekj,nj->pekn", ends, patches.normals) - offset
    above, below = height.min(axis=2) >= -touch, height.max(axis=2) <= touch
    open_ = above.all(axis=1) | below.all(axis=1)
    for side in (first, second):
        level = np.einsum("ij,ij->i", sides.normal[side], sides.centre[side])
        rise = sides.normal[side] @ patches.vertices.reshape(-1, 3).T - level[:, None]
        open_ |= (rise.reshape(len(side), -1, 4) <= touch).all(axis=2)
        open_ |= sides.surface[side][:, None] == patches.surface
    corners = ends.reshape(len(first), 8, 3)
    low, high = patches.vertices.min(axis=1), patches.vertices.max(axis=1)
    open_ |= (high <= corners.min(axis=1)[:, None] + touch).any(axis=2)
    open_ |= (low >= corners.max(axis=1)[:, None] - touch).any(axis=2)
    pair, patch = np.nonzero(~open_)
    crossed = (above[:, 0] & below[:, 1]) | (below[:, 0] & above[:, 1])
    hiding = np.flatnonzero(crossed[pair, patch])
    hides = _hides(ends[pair[hiding]], height[pair[hiding], :, :, patch[hiding]], patches.vertices[patch[hiding]],
                   patches.normals[patch[hiding]], touch)
    hidden = np.zeros(len(first), dtype=bool)
    hidden[pair[hiding[hides]]] = True
    aside = _aside(ends[pair], patches.vertices[patch], touch)
    blocked = np.zeros(len(first), dtype=bool)
    blocked[pair[~aside]] = True
    return hidden | ~blocked, np.where(hidden, 0.0, 1.0)


def _hides(ends, height, vertices, normals, touch):
    """Whether all segments between corners of two patches on the two sides of a plane pass through a patch in it."""
    drop = height[:, 0, :, None] - height[:, 1, None, :]
    flat = np.abs(drop) <= touch
    share = np.divide(height[:, 0, :, None], drop, out=np.zeros_like(drop), where=~flat)
    between = ends[:, 1, None, :, :] - ends[:, 0, :, None, :]
    crossing = ends[:, 0, :, None, :] + share[..., None] * between
    corner = vertices[:, None, None, :, :] - crossing[..., None, :]
    turn = np.einsum("cabki,ci->cabk", np.cross(corner, np.roll(corner, -1, axis=3)), normals)
    return ((turn >= 0).all(axis=3) & ~flat).all(axis=(1, 2))


def _aside(ends, vertices, touch):
    """Whether a plane through an edge of the one end and a corner of the other separates a patch from both ends."""
    aside = np.zeros(len(ends), dtype=bool)
    corners = ends.reshape(-1, 8, 3)
    for end in (0, 1):
        for edge in range(4):
            start = ends[:, end, edge]
            along = ends[:, end, (edge + 1) % 4] - start
            for corner in range(4):
                normal = np.cross(along, ends[:, 1 - end, corner] - start)
                length = np.linalg.norm(normal, axis=1, keepdims=True)
                normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
                own = np.einsum("cki,ci->ck", corners - start[:, None], normal)
                other = np.einsum("cki,ci->ck", vertices - start[:, None], normal)
                for sign in (1, -1):
                    aside |= ((length[:, 0] > 0) & (sign * own <= touch).all(axis=1)
                              & (sign * other >= -touch).all(axis=1))
    return aside
