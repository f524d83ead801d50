"""What the tests of shapes and built-in scenes measure on patches."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

__all__ = ["area_vectors", "components", "is_closed", "overlaps", "volume"]


def area_vectors(patches: np.ndarray) -> np.ndarray:
    """N x 3: normal times area."""
    return 0.5 * np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])


def volume(patches: np.ndarray) -> float:
    """Signed volume of a closed set of planar patches, positive with the fronts outwards."""
    return float(np.einsum("ni,ni->", patches[:, 0], area_vectors(patches))) / 3


def _numbered(patches: np.ndarray) -> np.ndarray:
    """N x 4 vertex numbers, equal for coordinates that are equal to the bit."""
    return np.unique(patches.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 4)


def is_closed(patches: np.ndarray) -> bool:
    """Whether each edge has exactly one partner that runs in the opposite direction between the same points."""
    corner = _numbered(patches)
    edges = np.stack([corner, np.roll(corner, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges = edges[edges[:, 0] != edges[:, 1]]
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    reverse = np.unique(edges[:, ::-1], axis=0)
    return bool((counts == 1).all() and np.array_equal(unique, reverse))


def components(patches: np.ndarray) -> list[np.ndarray]:
    """The patches of each part that hangs together by common vertices."""
    corner = _numbered(patches)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    size = int(corner.max()) + 1
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(size, size))
    count, label = connected_components(graph, directed=False)
    return [patches[label[corner[:, 0]] == number] for number in range(count)]


def overlaps(patches: np.ndarray, size: float) -> list[tuple[int, int]]:
    """Pairs of patches that cover a common area: same plane within 1e-6 of ``size``, either side to the front."""
    vectors = area_vectors(patches)
    normals = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    slack = 1e-6 * size
    lower, upper = patches.min(axis=1), patches.max(axis=1)
    pairs = []
    for first in range(0, len(patches), 64):
        i = np.arange(first, min(first + 64, len(patches)))
        near = (i[:, None] < np.arange(len(patches)))
        for axis in range(3):
            near &= lower[:, axis] <= upper[i, None, axis] + slack
            near &= upper[:, axis] >= lower[i, None, axis] - slack
        i, j = np.nonzero(near)
        pairs.append((i + first, j))
    i, j = (np.concatenate(side) for side in zip(*pairs, strict=True))
    coplanar = np.linalg.norm(np.cross(normals[j], normals[i]), axis=1) < 1e-6
    coplanar &= np.abs(np.einsum("pi,pi->p", patches[j, 0] - patches[i, 0], normals[i])) < slack
    i, j = i[coplanar], j[coplanar]
    # Two convex polygons overlap if no side of either has the other one outside.
    separated = np.zeros(len(i), dtype=bool)
    for one, other in ((i, j), (j, i)):
        sides = np.roll(patches[one], -1, axis=1) - patches[one]
        length = np.linalg.norm(sides, axis=2)
        inward = np.cross(normals[one][:, None], sides) / np.maximum(length, 1e-300)[..., None]
        reach = np.einsum("pki,pkvi->pkv", inward, patches[other][:, None] - patches[one][:, :, None]).max(axis=2)
        separated |= ((reach < slack) & (length > 0)).any(axis=1)
    return list(zip(i[~separated].tolist(), j[~separated].tolist(), strict=True))
