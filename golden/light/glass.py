"""Light that passes clear surfaces straight or leaves flat mirrors, and the share that glass mirrors."""

from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss

from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["SHEETS", "ClearRays", "Glass", "fresnel"]

SHEETS = 8
"""Most clear surfaces that shadow rays and the rays of hemispheres pass; mirrors count as well."""

# A flat surface that mirrors less in each channel diffuses it in the first pass: what it throws is weak.
MIRROR = 0.5
# A flat mirror throws at most this share in a scene with lights without an area: the rest diffuses their light.
MOST_THROWN = 0.99


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

    Members
    -------
    clear
        N bool: whether the patch is transparent at all.
    thin
        N bool: whether it is a sheet, which does not bend rays.
    mirrors
        N bool: whether it is a flat mirror.
    throws
        N bool: whether rays of the first pass leave it as from a mirror: flat mirrors, and flat sheets in a scene
        without lights that have no area. These light no ray: what sheets mirror of them counts as diffuse.

    Source: Born and Wolf, Principles of Optics, 1.5.2 and 7.6.1 (incoherent).
    """

    def __init__(self, scene: Scene):
        self._transparent, self._index = scene.channels("transparent"), scene.channels("refraction_index")
        self.clear = self._transparent.any(axis=1)
        specular = scene.channels("specular")
        self.mirrors = ~self.clear & ~scene.is_curved & (specular.max(axis=1) >= MIRROR)
        most = MOST_THROWN if scene.lights else 1.0
        self._specular = np.where(self.mirrors[:, None], np.minimum(specular, most), 0.0)
        self.thin = np.array([material.thin for material in scene.materials], dtype=bool)[scene.material]
        self.throws = self.mirrors | (self.clear & self.thin & ~scene.is_curved & (not scene.lights))

    @property
    def goes_on(self) -> np.ndarray:
        """N bool: whether rays of the first pass pass the patch or leave it as from a mirror."""
        return self.clear | self.throws

    def mirrored(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that patches mirror, by the cosines of the rays with their normals in the thin medium."""
        index = self._index[patch]
        cosine = np.clip(cosine, 1e-6, 1)
        surface = fresnel(1 / index, cosine, np.sqrt(cosine**2 + (index**2 - 1)) / index)
        return np.where(self.thin[patch], 2 * surface / (1 + surface), surface)

    def passed(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that passes, K x 3."""
        return self._transparent[patch] * (1 - self.mirrored(patch, cosine))[:, None]

    def thrown(self, patch: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of K rays that leaves as from a mirror, K x 3."""
        sheet = np.where(self.throws[patch], self.mirrored(patch, cosine), 0.0)
        return self._specular[patch] + self._transparent[patch] * sheet[:, None]

    @cached_property
    def mean_passed(self) -> np.ndarray:
        """N x 3: share of diffuse light that passes each patch."""
        return self._transparent * (1 - self._mean_mirrored)[:, None]

    @cached_property
    def mean_thrown(self) -> np.ndarray:
        """N x 3: share of diffuse light that leaves as from a mirror."""
        sheet = np.where(self.throws, self._mean_mirrored, 0.0)
        return self._specular + self._transparent * sheet[:, None]

    @cached_property
    def _mean_mirrored(self):
        knots, weights = leggauss(64)
        cosine = knots / 2 + 0.5
        patches = np.arange(len(self.clear))
        return sum(weight * at * self.mirrored(patches, np.full(len(patches), at))
                   for at, weight in zip(cosine.tolist(), weights.tolist(), strict=True))

    @property
    def colours(self) -> list[list[int]]:
        """The channels in groups, of which each sees all patches equally clear, and mirrors alike."""
        groups: dict[bytes, list[int]] = {}
        for channel in range(3):
            key = np.stack([self._transparent[:, channel], self._specular[:, channel]]).tobytes()
            groups.setdefault(key, []).append(channel)
        return list(groups.values())


class ClearRays:
    """Rays with whole-numbered weights that pass the clear surfaces of a scene and leave its mirrors.

    Parameters
    ----------
    scene, glass
        The patches, and which of them are clear or mirrors.
    caster
        Casts the rays that go on.
    channel
        The colour channel, 0 to 2, whose light is followed.
    """

    def __init__(self, scene: Scene, glass: Glass, caster, channel: int):
        self._scene, self._glass, self._caster, self._channel = scene, glass, caster, channel
        self._emission = scene.channels("emission")

    def passed(self, rays: Rays, hits: Hits, weight: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
        """R int64: what of the weights of R rays passes the patches that they hit; of mirrored ones all that goes on.

        So no sheet mirrors twice, and no two sheets mirror to and fro.
        """
        share = self._share(self._glass.passed, self._glass.clear, rays, hits)
        if mirrored.any():
            share += np.where(mirrored, self._share(self._glass.thrown, self._glass.clear, rays, hits), 0.0)
        return np.rint(share * weight).astype(np.int64)

    def thrown(self, rays: Rays, hits: Hits, weight: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
        """R int64: what of the weights of R rays leaves the patches that they hit as from a mirror."""
        share = self._share(self._glass.thrown, self._glass.throws, rays, hits)
        share[mirrored & self._glass.clear[hits.patch]] = 0
        share[self._glass.mirrors[hits.patch] & ~self._active(rays, hits)] = 0
        return np.rint(share * weight).astype(np.int64)

    def behind(self, rays: Rays, hits: Hits) -> tuple[Rays, Hits]:
        """The rays from their hits straight on, and what these hit."""
        return self._onward(rays, hits, rays.direction)

    def from_mirror(self, rays: Rays, hits: Hits) -> tuple[Rays, Hits]:
        """The mirrored rays, and what these hit."""
        normal = self._scene.normals[hits.patch]
        along = np.einsum("kj,kj->k", rays.direction, normal)
        return self._onward(rays, hits, rays.direction - 2 * along[:, None] * normal)

    def emission(self, rays: Rays, hits: Hits) -> np.ndarray:
        """R x 3: radiance that patches emit towards the rays that hit them."""
        return np.where(self._active(rays, hits)[:, None], self._emission[hits.patch], 0.0)

    def _share(self, share_of, which, rays, hits):
        share = np.zeros(len(rays))
        some = np.flatnonzero(which[hits.patch])
        patch, direction = hits.patch[some], rays.direction[some]
        cosine = np.abs(np.einsum("kj,kj->k", direction, self._scene.normals[patch]))
        share[some] = share_of(patch, cosine / np.linalg.norm(direction, axis=1))[:, self._channel]
        return share

    def _onward(self, rays, hits, direction):
        later = Rays(rays.origin + hits.t[:, None] * rays.direction, direction, self._scene.surface[hits.patch])
        return later, self._caster.nearest(later)

    def _active(self, rays, hits):
        front = np.einsum("kj,kj->k", rays.direction, self._scene.normals[hits.patch]) < 0
        return front | self._scene.two_sided[hits.patch]
