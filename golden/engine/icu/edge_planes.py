"""Edge planes: the planes through the origin and each edge and diagonal of a patch, exact."""

from dataclasses import dataclass

import numpy as np

from golden.engine.config import Numbers

__all__ = ["DIAGONAL", "EDGES", "EdgePlanes", "edge_planes"]

# Vertices of each plane, in the order of `EdgePlanes.planes`: four edges, two diagonals.
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3))
# Index of the diagonal that cuts a patch into the triangles (0, 1, 2) and (0, 2, 3).
DIAGONAL = 4


@dataclass(frozen=True, eq=False)
class EdgePlanes:
    """Edge planes of P patches.

    Parameters
    ----------
    planes
        P x 6 x 3 int64, V'_i x V'_j, see `EDGES`.
    orientation
        P x 2 int64: sign of det(V'_0, V'_1, V'_2) and of det(V'_0, V'_2, V'_3). The second is 0 for a triangle.
    split
        P bool: the projection is not strictly convex, so the patch is tested as its two triangles, each with its own
        orientation. The first orientation of an unsplit patch is that of the whole patch.
    """

    planes: np.ndarray
    orientation: np.ndarray
    split: np.ndarray

    def __getitem__(self, rows) -> "EdgePlanes":
        return EdgePlanes(self.planes[rows], self.orientation[rows], self.split[rows])


def edge_planes(directions: np.ndarray, numbers: Numbers) -> EdgePlanes:
    """The planes of P patches from their V' (P x 4 x 3 int64), exact."""
    first, second = (directions[:, [edge[end] for edge in EDGES]] for end in range(2))
    planes = numbers.edge_plane.check(np.cross(first, second), "edge plane")
    # The triples (0, 1, 2), (1, 2, 3), (2, 3, 0) and (3, 0, 1): each edge with the vertex after it.
    winding = np.sign(np.einsum("pei,pei->pe", planes[:, :4], np.roll(directions, -2, axis=1)))
    convex = (winding[:, 0] != 0) & (winding == winding[:, :1]).all(axis=1)
    is_triangle = (directions[:, 2] == directions[:, 3]).all(axis=1)
    return EdgePlanes(planes, winding[:, [0, 2]], ~convex & ~is_triangle)
