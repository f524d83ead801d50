"""Screens of an eye behind flat mirrors and thin panes: the host's part of casting them in the machine's integers.

What a flat mirror shows is what the mirrored eye sees through it, and what a thin pane lets pass is what the eye sees
beyond it. So all rays of a picture that meet one plane are rays of one screen, among the patches with a part beyond the
plane. Of a patch that crosses the plane a ray may hit the part before it: such rays are left to others.

Source: Shen 1993, sections 2.5 and 5.3.2.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from golden.cast.known_patches import hits_of_patches
from golden.cast.oracle import Oracle
from golden.cast.rays import Hits, Rays
from golden.cast.screen import Screen
from golden.scene.scene import Scene

__all__ = ["SpecularCaster", "SpecularPlane", "specular_planes"]

# Primary rays of a picture that meet a plane, at least: its frustum has patches of its own, which the machine loads.
_LEAST = 256
# Float32 moves corners off their common plane by at most this share of the scene's size, and turns the normals of
# patches by less than this: the machine rounds directions to 2^-16, and a mirror doubles the turn.
_FLAT, _TURN = 2.0**-24, 2.0**-18
# Patches that reach less far beyond a plane, as a share of the scene's size, are in it.
_THIN = 2.0**-32


@dataclass(frozen=True, kw_only=True, eq=False)
class SpecularPlane:
    """A plane of mirrors or clear surfaces that enough rays of a picture meet.

    Parameters
    ----------
    scene
        The patches.
    point, normal
        A point of the plane, and its unit normal towards the eye.
    own
        The patches in it that the rays meet.
    fields
        The numbers of the rays, in order.
    """

    scene: Scene
    point: np.ndarray
    normal: np.ndarray
    own: np.ndarray
    fields: np.ndarray

    def screen(self, screen: Screen, *, is_mirrored: bool) -> tuple[Screen, np.ndarray]:
        """What the rays of a picture are rays of where they go on, and their numbers in it: the picture's screen, or
        the one of its mirrored eye.
        """
        if not is_mirrored:
            return screen, self.fields
        camera = screen.camera
        eye, target = (point - 2 * np.dot(point - self.point, self.normal) * self.normal
                       for point in (camera.eye, camera.target))
        camera = replace(camera, eye=eye, target=target,
                         up=camera.up - 2 * np.dot(camera.up, self.normal) * self.normal)
        # Cameras are right-handed: what a mirror shows is turned around left and right.
        row, column = np.divmod(self.fields, screen.width)
        return replace(screen, camera=camera), (row + 1) * screen.width - 1 - column

    def beyond(self, *, is_mirrored: bool) -> np.ndarray:
        """The patches with a part where the rays go on, in order; none of a surface that they leave."""
        scene, own = self.scene, self.own
        depth = (scene.vertices - self.point) @ (self.normal if is_mirrored else -self.normal)
        # Patches that rays leave are planar only to rounding: corners of theirs, and of their backs, may be beyond.
        left = np.isin(scene.surface, scene.surface[own if scene.behind is None else np.append(own, scene.behind[own])])
        return np.flatnonzero((depth.max(axis=1) > _THIN * scene.size - np.abs(depth[own]).max()) & ~left)


def specular_planes(scene: Scene, eye: np.ndarray, patch: np.ndarray) -> Iterator[SpecularPlane]:
    """The planes that at least 256 rays from an eye meet, which hit these patches, or -1."""
    is_specular = (scene.channels("specular") + scene.channels("transparent")).any(axis=1)
    rays = np.bincount(patch[patch >= 0], minlength=len(scene)) * is_specular
    met = np.flatnonzero(rays)
    normals = scene.normals[met]
    normals *= np.sign(np.einsum("kj,kj->k", normals, eye - scene.centres[met]))[:, None]
    offset = np.einsum("kj,kj->k", normals, scene.centres[met] - scene.bounds.mean(axis=0)) / scene.size
    # Patches whose normals and places lie without gaps are one group, axis by axis.
    group = np.zeros(len(met), dtype=np.int64)
    for values in (*normals.T, offset):
        order = np.lexsort((values, group))
        ends = (np.diff(values[order]) > _TURN) | (np.diff(group[order]) > 0)
        group[order] = np.cumsum(np.append(False, ends)[:len(met)])
    enough = np.bincount(group, weights=rays[met]) >= _LEAST
    plane = np.full(len(scene), -1)
    found = []
    for one in np.flatnonzero(enough):
        own = met[group == one]
        corners = scene.vertices[own]
        middle = corners.mean(axis=(0, 1))
        normal = np.linalg.svd((corners - middle).reshape(-1, 3), full_matrices=False)[2][2]
        normal *= np.sign(np.dot(normal, eye - middle))
        height = (corners - middle) @ normal
        point = middle + np.median(height) * normal
        is_flat = (np.abs((corners - point) @ normal).max(axis=1) <= _FLAT * scene.size) & (
            np.abs(normals[group == one] - normal).max(axis=1) <= _TURN)
        own = own[is_flat]
        if rays[own].sum() >= _LEAST:
            plane[own] = len(found)
            found.append({"point": point, "normal": normal, "own": own})
    fields = np.flatnonzero(patch >= 0)
    fields = fields[np.argsort(plane[patch[fields]], kind="stable")]
    places = np.searchsorted(plane[patch[fields]], np.arange(len(found) + 1))
    for one, first, end in zip(found, places[:-1], places[1:], strict=True):
        yield SpecularPlane(scene=scene, fields=fields[first:end], **one)


class SpecularCaster:
    """Casts the rays of a picture behind flat mirrors and thin panes.

    Which ones depends on the picture alone: where at least 256 of its primary rays meet one plane, all of them are cast
    as soon as one is requested. Their patches are kept, and no more than that.

    Parameters
    ----------
    oracle, screen, frusta
        The patches, the picture with a ray in the middle of each field, and a
        `golden.engine.cast.fixed_frusta.FixedFrusta`, which casts screens.

    Members
    -------
    rays
        How many it has cast.
    """

    def __init__(self, oracle: Oracle, screen: Screen, frusta):
        self._oracle, self._screen, self._frusta, self.rays = oracle, screen, frusta, 0
        # By whether they are reflected: of each field patch, tests and steps, and the planes that have been cast.
        self._found: dict[bool, tuple[np.ndarray, set[int]]] = {}

    @cached_property
    def _planes(self):
        """The planes, and of each field the number of its plane, or -1."""
        scene, screen = self._oracle.scene, self._screen
        patch = scene.facing(self._frusta.patches(screen), screen.rays().direction)
        planes = [*specular_planes(scene, np.array(screen.camera.eye), patch)]
        number = np.full(len(screen), -1)
        for one, plane in enumerate(planes):
            number[plane.fields] = one
        return planes, number

    def nearest(self, rays: Rays, field: np.ndarray, *, is_mirrored: bool) -> tuple[np.ndarray, Hits]:
        """The hits of rays that are in a frustum.

        Parameters
        ----------
        rays
            K rays from where those of the picture meet flat patches.
        field
            K: their numbers in the picture.
        is_mirrored
            Whether they are reflected, or go straight on.

        Returns
        -------
        The numbers of the rays that are cast, and their hits.
        """
        planes, plane = self._planes
        if is_mirrored not in self._found:
            self._found[is_mirrored] = np.zeros((3, len(self._screen)), dtype=np.int32), set()
        found, known = self._found[is_mirrored]
        rows = np.flatnonzero(plane[field] >= 0)
        for one in np.setdiff1d(plane[field[rows]], [*known]).tolist():
            found[:, planes[one].fields] = self._cast(planes[one], is_mirrored)
            known.add(one)
        patch, tests, steps = found[:, field[rows]].astype(np.int64)
        keep = ~self._is_before(rays, rows, patch)
        self.rays += np.count_nonzero(keep)
        return rows[keep], hits_of_patches(self._oracle, rays[rows[keep]], patch[keep], tests=tests[keep],
                                           steps=steps[keep])

    def _cast(self, plane, is_mirrored):
        """Patch, tests and steps of each of the rays that meet a plane."""
        beyond = plane.beyond(is_mirrored=is_mirrored)
        if not len(beyond):
            return [[-1], [0], [0]]
        patch, tests, steps = self._frusta.beyond(beyond, *plane.screen(self._screen, is_mirrored=is_mirrored))
        return np.where(patch >= 0, beyond[patch], -1), tests, steps

    def _is_before(self, rays, rows, patch):
        """Whether rays start in or beyond the plane of the patch that they are said to meet: K bool."""
        scene = self._oracle.scene
        normal = scene.normals[patch]
        height = np.einsum("kj,kj->k", normal, scene.vertices[patch].mean(axis=1) - rays.origin[rows])
        fall = np.einsum("kj,kj->k", normal, rays.direction[rows])
        return (patch >= 0) & (height * np.sign(fall) <= 2 * _FLAT * scene.size)
