"""Light that passes clear surfaces straight or leaves flat mirrors, and the share that glass mirrors."""

from functools import cached_property

import numpy as np
from scipy.special import roots_legendre

from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["SHEETS", "ClearRays", "Glass", "fresnel"]

SHEETS = 8
"""Most clear surfaces that shadow rays and the rays of hemispheres pass; mirrors count as well."""

# A flat surface that mirrors less in each channel diffuses it in the first pass: what it throws is weak.
MIRROR = 0.5


def fresnel(ratio, cosine, beyond) -> np.ndarray:
    """Reflectance of a smooth dielectric for unpolarised light.

    Parameters
    ----------
    ratio
        Index of refraction on the ray's side over that beyond the surface.
    cosine, beyond
        Cosines of the ray and of the refracted ray.
    """
    parallel = (cosine - ratio * beyond) / (cosine + ratio * beyond)
    across = (ratio * cosine - beyond) / (ratio * cosine + beyond)
    return (parallel**2 + across**2) / 2


class Glass:
    """The clear surfaces of a scene, as rays that pass them straight meet them.

    A face of a body is one surface of Fresnel's reflectance R; a thin sheet has two, between which light is reflected
    to and fro: it mirrors 2 R / (1 + R). The rest of the transparent share passes. For a pane with parallel faces,
    sheet or body, that is exact but for the offset of the rays.

    Parameters
    ----------
    scene
        The patches.

    Members
    -------
    clear
        N bool: whether the patch is transparent at all.
    thin
        N bool: whether it is a sheet, which does not bend rays.
    mirrors
        N bool: whether it is a flat mirror.

    Source: Born and Wolf, Principles of Optics, 1.5.2 and 7.6.1 (incoherent).
    """

    def __init__(self, scene: Scene):
        self._transparent, self._index = scene.channels("transparent"), scene.channels("refraction_index")
        self.clear = self._transparent.any(axis=1)
        specular = scene.channels("specular")
        self.mirrors = ~self.clear & ~scene.is_curved & (specular.max(axis=1) >= MIRROR)
        self._specular = np.where(self.mirrors[:, None], specular, 0.0)
        self.thin = np.array([material.thin for material in scene.materials], dtype=bool)[scene.material]

    def mirrored(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that patches mirror, by the cosines of the rays with their normals in the thin medium."""
        index = self._index[patch]
        cosine = np.clip(cosine, 1e-6, 1)
        surface = fresnel(1 / index, cosine, np.sqrt(cosine**2 + (index**2 - 1)) / index)
        return np.where(self.thin[patch], 2 * surface / (1 + surface), surface)

    def passed(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that passes, K x 3."""
        return self._transparent[patch] * (1 - self.mirrored(patch, cosine))[:, None]

    def leaves(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that passes, or that a flat mirror throws back, K x 3."""
        return self.passed(patch, cosine) + self._specular[patch]

    @cached_property
    def mean_passed(self) -> np.ndarray:
        """N x 3: share of diffuse light that passes each patch, or that it throws back as a flat mirror."""
        knots, weights = roots_legendre(64)
        cosine = knots / 2 + 0.5
        patches = np.arange(len(self.clear))
        mean = sum(weight * at * self.mirrored(patches, np.full(len(patches), at))
                   for at, weight in zip(cosine.tolist(), weights.tolist(), strict=True))
        return self._transparent * (1 - mean)[:, None] + self._specular

    @property
    def colours(self) -> list[list[int]]:
        """The channels in groups, of which each sees all patches equally clear, and mirrors alike."""
        groups: dict[bytes, list[int]] = {}
        for channel in range(3):
            key = np.stack([self._transparent[:, channel], self._specular[:, channel]]).tobytes()
            groups.setdefault(key, []).append(channel)
        return list(groups.values())


class ClearRays:
    """Rays with whole-numbered weights that pass the clear surfaces of a scene and leave its flat mirrors.

    Parameters
    ----------
    scene, glass
        The patches, and which of them are clear or mirrors.
    caster
        Casts the rays behind them.
    channel
        The colour channel, 0 to 2, whose light is followed.

    Members
    -------
    is_mirror
        N bool: whether a patch is a flat mirror.
    """

    def __init__(self, scene: Scene, glass: Glass, caster, channel: int):
        self._scene, self._glass, self._caster, self._channel = scene, glass, caster, channel
        self._emission = scene.channels("emission")
        self.is_mirror = glass.mirrors

    def passed(self, rays: Rays, hits: Hits, weight: np.ndarray) -> np.ndarray:
        """R int64: what of the weights of R rays goes on from the patches that they hit."""
        passed = np.zeros(len(weight), dtype=np.int64)
        some = np.flatnonzero(self._glass.clear[hits.patch] | (self.is_mirror[hits.patch] & self._active(rays, hits)))
        patch, direction = hits.patch[some], rays.direction[some]
        cosine = np.abs(np.einsum("kj,kj->k", direction, self._scene.normals[patch]))
        share = self._glass.leaves(patch, cosine / np.linalg.norm(direction, axis=1))[:, self._channel]
        passed[some] = np.rint(share * weight[some]).astype(np.int64)
        return passed

    def behind(self, rays: Rays, hits: Hits) -> tuple[Rays, Hits]:
        """The rays from their hits on, and what these hit."""
        direction, mirror = rays.direction, np.flatnonzero(self.is_mirror[hits.patch])
        if len(mirror):
            normal, direction = self._scene.normals[hits.patch[mirror]], direction.copy()
            along = np.einsum("kj,kj->k", direction[mirror], normal)
            direction[mirror] -= 2 * along[:, None] * normal
        later = Rays(rays.origin + hits.t[:, None] * rays.direction, direction, self._scene.surface[hits.patch])
        return later, self._caster.nearest(later)

    def emission(self, rays: Rays, hits: Hits) -> np.ndarray:
        """R x 3: radiance that patches emit towards the rays that hit them."""
        return np.where(self._active(rays, hits)[:, None], self._emission[hits.patch], 0.0)

    def _active(self, rays, hits):
        front = np.einsum("kj,kj->k", rays.direction, self._scene.normals[hits.patch]) < 0
        return front | self._scene.two_sided[hits.patch]
