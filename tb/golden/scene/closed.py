"""What the tests of surfaces share: whether patches fit together."""

from collections import Counter

import numpy as np

__all__ = ["assert_closed", "assert_good_patches"]


def assert_closed(patches: np.ndarray) -> None:
    """Every edge belongs to exactly two patches, which run along it in opposite directions."""
    _, corner = np.unique(patches.reshape(-1, 3), axis=0, return_inverse=True)
    start = corner.reshape(-1, 4)
    end = np.roll(start, -1, axis=1)
    edges = Counter(zip(start[start != end].tolist(), end[start != end].tolist(), strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)


def assert_good_patches(patches: np.ndarray, size: float) -> None:
    """Areas are positive, quads planar and strictly convex, within 1e-9 of ``size``."""
    vectors = 0.5 * np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])
    areas = np.linalg.norm(vectors, axis=1)
    assert areas.min() > (1e-9 * size) ** 2
    normals = vectors / areas[:, None]
    heights = np.einsum("nij,nj->ni", patches - patches[:, :1], normals)
    assert np.abs(heights).max() <= 1e-9 * size
    quads = (patches[:, 3] != patches[:, 2]).any(axis=1)
    ahead = np.roll(patches, -1, axis=1) - patches
    winding = np.einsum("nij,nj->ni", np.cross(np.roll(ahead, 1, axis=1), ahead), normals)[quads]
    # Distance of a corner from the line through its neighbours.
    chords = np.linalg.norm(np.roll(patches, -1, axis=1) - np.roll(patches, 1, axis=1), axis=2)[quads]
    assert (winding > 1e-9 * size * chords).all()
