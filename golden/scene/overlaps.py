"""Patches of one plane that overlap."""


import numpy as np

from golden.base.input_warnings import warn
from golden.base.plural import counted
from golden.scene.scene import Scene

__all__ = ["overlaps", "warn_of_overlaps"]

# Share of the scene's size by which patches may reach into each other, and difference of unit normals of one plane.
_TOUCH, _PARALLEL = 2.0**-32, 2.0**-24

# Pairs per block, which bounds memory.
_BLOCK = 1 << 18


def overlaps(scene: Scene, which: np.ndarray | None = None) -> np.ndarray:
    """Pairs of patches of one plane that cover a common part of it, P x 2 int64, the lower number first, in order.

    One-sided patches with opposite fronts are a thin wall and no such pair.

    Parameters
    ----------
    which
        N bool: only pairs of one of these and one of the others. Default: all pairs.
    """
    touch = _TOUCH * scene.size
    plane, sign = _planes(scene, touch)
    if which is None:
        return _pairs(scene, plane, sign, touch)
    rows = np.flatnonzero(np.isin(plane, np.intersect1d(plane[which], plane[~which])))
    if not len(rows):
        return np.empty((0, 2), dtype=np.int64)
    pairs = rows[_pairs(scene.with_parts(rows), np.unique(plane[rows], return_inverse=True)[1], sign[rows], touch)]
    return pairs[which[pairs[:, 0]] != which[pairs[:, 1]]]


def _pairs(scene, plane, sign, touch):
    drop = np.abs(scene.normals).argmax(axis=1)
    # Patches of one plane share its axes, also where two components of the normal are equal.
    first = np.unique(plane, return_index=True)[1]
    kept = np.array([(1, 2), (0, 2), (0, 1)])[drop[first][plane]]
    flat = np.take_along_axis(scene.vertices - scene.bounds[0], kept[:, None, :], axis=2)
    low, high = flat.min(axis=1), flat.max(axis=1)
    # Planes follow each other along one line, which is swept.
    shift = plane * (2 * scene.size)
    order = np.argsort(low[:, 0] + shift, kind="stable")
    ends = np.searchsorted((low[:, 0] + shift)[order], (high[:, 0] + shift)[order] - touch)
    counts = np.maximum(ends - np.arange(len(order)) - 1, 0)
    total, found = np.cumsum(counts), []
    for start in range(0, int(total[-1]), _BLOCK):
        number = np.arange(start, min(start + _BLOCK, total[-1]))
        position = np.searchsorted(total, number, side="right")
        one = order[position]
        other = order[position + 1 + number - (total - counts)[position]]
        near = ((plane[one] == plane[other])
                & (np.minimum(high[one], high[other]) - np.maximum(low[one], low[other]) > touch).all(axis=1)
                & ((sign[one] == sign[other]) | scene.two_sided[one] | scene.two_sided[other]))
        one, other = one[near], other[near]
        apart = _apart(scene, one, other, touch) | _apart(scene, other, one, touch)
        found.append(np.sort(np.stack([one, other], axis=1)[~apart], axis=1))
    pairs = np.concatenate(found) if found else np.empty((0, 2), dtype=np.int64)
    return pairs[np.lexsort(pairs.T[::-1])]


def warn_of_overlaps(scene: Scene, *, number: np.ndarray | None = None) -> None:
    """Names the first patches that overlap in one `InputWarning`; nothing if there are none.

    ``number`` has the number of each patch in the message. Default: its own.
    """
    pairs = overlaps(scene)
    if len(pairs):
        more = f", and {counted(len(pairs) - 1, 'more pair')}" if len(pairs) > 1 else ""
        one, other = pairs[0] if number is None else number[pairs[0]]
        warn(f"{scene.name}: patches {one} and {other} overlap in one plane{more}: each counts "
             "as a whole, so view factors to them are too large")


def _planes(scene, touch):
    """A number for the plane of each patch, and the sign of its normal there."""
    normal = scene.normals
    large = np.abs(normal) > 1e-6
    sign = np.sign(normal[np.arange(len(normal)), large.argmax(axis=1)])
    normal = normal * sign[:, None]
    height = np.einsum("ni,ni->n", normal, scene.centres - scene.bounds[0])
    plane = np.zeros(len(normal), dtype=np.int64)
    for values, gap in ((height, touch), *((column, _PARALLEL) for column in normal.T)):
        order = np.lexsort((values, plane))
        new = (np.diff(plane[order]) > 0) | (np.diff(values[order]) > gap)
        plane[order] = np.concatenate([[0], np.cumsum(new)])
    return plane, sign


def _apart(scene, one, other, touch):
    """Whether an edge of the one patch separates it from the other."""
    corners = scene.vertices[one]
    along = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(along, axis=2)
    inwards = np.cross(scene.normals[one][:, None], along)
    rise = np.einsum("pki,pcki->pck", inwards, scene.vertices[other][:, :, None] - corners[:, None])
    return ((rise <= touch * length[:, None]).all(axis=1) & (length > 0)).any(axis=1)
