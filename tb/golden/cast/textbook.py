"""Rays against patches in float64 by the textbook, with nothing of golden's setup of patches, rays or frames.

A ray is an origin and a unit direction in the scene; a patch is one or two triangles, tested by Möller and Trumbore.
"""

import numpy as np

__all__ = ["Textbook", "hemisphere_directions", "screen_directions"]


def hemisphere_directions(axes, azimuths: int, polars: int) -> np.ndarray:
    """Unit directions through the middles of the cells around the last of three axes, polar angle by polar angle."""
    polar = np.repeat((np.arange(polars) + 0.5) * np.pi / 2 / polars, azimuths)
    azimuth = np.tile((np.arange(azimuths) + 0.5) * 2 * np.pi / azimuths, polars)
    return (np.sin(polar) * np.cos(azimuth))[:, None] * axes[0] + (np.sin(polar) * np.sin(azimuth))[:, None] * axes[1] \
        + np.cos(polar)[:, None] * axes[2]


def screen_directions(eye, target, up, fov: float, width: int, height: int) -> np.ndarray:
    """Directions of depth 1 through the middles of the pixels, rows from the top; ``fov`` in degrees, vertically."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    pitch = 2 * np.tan(np.radians(fov) / 2) / height
    x = np.tile((np.arange(width) - (width - 1) / 2) * pitch, height)
    y = np.repeat(((height - 1) / 2 - np.arange(height)) * pitch, width)
    return forward + x[:, None] * right + y[:, None] * above


class Textbook:
    """All patches against all rays from one point.

    Parameters
    ----------
    vertices
        N x 4 x 3, scene units; a triangle repeats its last vertex.
    skipped
        N bool: patches that no ray hits.
    """

    def __init__(self, vertices: np.ndarray, skipped: np.ndarray):
        self._corner = np.concatenate([vertices[:, [0, 1, 2]], vertices[:, [0, 2, 3]]])
        self._skipped = np.tile(skipped, 2)
        self._patches = len(vertices)

    def distances(self, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Parameter of each ray's hit with each patch, rays x patches, inf for none."""
        corner, first, second = (self._corner[:, 0], self._corner[:, 1] - self._corner[:, 0],
                                 self._corner[:, 2] - self._corner[:, 0])
        start = origin - corner
        # Of each triangle determinants of its edges and the ray, all rays at once.
        normal, side = np.cross(first, second), np.cross(start, first)
        other = np.cross(second, start)
        with np.errstate(divide="ignore", invalid="ignore"):
            volume = -direction @ normal.T
            u, v = direction @ other.T / volume, direction @ side.T / volume
            t = np.einsum("ki,ki->k", normal, start) / volume
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & ~self._skipped
        t = np.where(hit, t, np.inf)
        return np.minimum(t[:, :self._patches], t[:, self._patches:])

    def nearest(self, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The patch of each ray, -1 for none, and the parameter of its hit."""
        t = self.distances(origin, direction)
        patch = t.argmin(axis=1)
        least = t[np.arange(len(t)), patch]
        return np.where(np.isfinite(least), patch, -1), least

    def may_be(self, patch: np.ndarray, origin: np.ndarray, direction: np.ndarray, *, angle, depth) -> np.ndarray:
        """Whether each ray, turned by up to some angle, hits a patch that is nearest but for a share of its distance.

        Parameters
        ----------
        patch
            R, the patch of each ray, -1 for none.
        angle, depth
            R or scalar: the angle in radians, and the share.
        """
        length = np.linalg.norm(direction, axis=1, keepdims=True)
        unit = direction / length
        across = np.cross(unit, np.eye(3)[np.abs(unit).argmin(axis=1)])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        down, angle = np.cross(unit, across), np.broadcast_to(angle, len(unit))[:, None]
        explained = np.zeros(len(unit), dtype=bool)
        for share in 0, 0.3, 1:
            for turn in np.arange(16) * np.pi / 8 if share else [0]:
                turned = unit + share * angle * (np.cos(turn) * across + np.sin(turn) * down)
                t = self.distances(origin, turned)
                own = np.where(patch >= 0, t[np.arange(len(t)), patch], np.inf)
                nearest = t.min(axis=1)
                explained |= np.where(patch >= 0, own <= nearest * (1 + depth), ~np.isfinite(nearest)) \
                    & (np.isfinite(own) | (patch < 0))
        return explained
