"""Points on patches, with their shading normals."""

from dataclasses import dataclass

import numpy as np

from golden.scene.scene import Scene

__all__ = ["SurfacePoints", "bilinear", "corner_normals"]


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """M points of a scene's surfaces, each seen from one side, or in space.

    Parameters
    ----------
    position
        M x 3, scene units.
    normal
        M x 3 unit shading normals on that side.
    patch
        M int, the patch of each point, or -1.
    """

    position: np.ndarray
    normal: np.ndarray
    patch: np.ndarray

    def __len__(self) -> int:
        return len(self.patch)

    def sources(self, scene: Scene) -> np.ndarray:
        """M int: the surface of each point, which its rays never hit, or -1."""
        return np.where(self.patch < 0, -1, scene.surface[self.patch])

    def __getitem__(self, rows) -> "SurfacePoints":
        return SurfacePoints(self.position[rows], self.normal[rows], self.patch[rows])


def bilinear(corners: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Corner values M x 4 x C at bilinear coordinates (u, v): M x C."""
    u, v = u[:, None], v[:, None]
    return (1 - v) * ((1 - u) * corners[:, 0] + u * corners[:, 1]) + v * ((1 - u) * corners[:, 3] + u * corners[:, 2])


def corner_normals(scene: Scene) -> np.ndarray:
    """Unit shading normals at the patches' corners, N x 4 x 3.

    Patches of one smooth group that meet at a point share the mean of their normals there, weighted by area.
    """
    points = scene.vertices.reshape(-1, 3)
    keys = np.column_stack([np.repeat(scene.smooth, 4).astype(np.float64), points + 0.0])
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    # A triangle's last two corners are one and count once.
    share = np.where(np.repeat(scene.is_triangle, 4) & (np.arange(len(points)) % 4 == 3), 0.0, 1.0)
    weights = np.repeat(scene.area_vectors, 4, axis=0) * share[:, None]
    total = np.stack([np.bincount(corner, weights[:, axis]) for axis in range(3)], axis=1)[corner]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # Where a group folds back on itself the mean vanishes: each patch keeps its own normal.
    own = np.repeat(scene.normals, 4, axis=0)
    normals = np.where(length > 1e-6 * np.repeat(scene.areas, 4)[:, None], total / np.maximum(length, 1e-300), own)
    return normals.reshape(-1, 4, 3)
