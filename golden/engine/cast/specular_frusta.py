"""Screens of an eye behind flat mirrors and thin panes: the host's part of casting them in the machine's integers.

What a flat mirror shows is what the mirrored eye sees through it, and what a thin pane lets pass is what the eye sees
beyond it. So all rays of a picture that meet one plane are rays of one screen, among the patches with a part beyond the
plane. Of a patch that crosses the plane a ray may hit the part before it: such rays are left to others.

Source: Shen 1993, sections 2.5 and 5.3.2.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from golden.cast.known_patches import hits_of_patches
from golden.cast.oracle import Oracle
from golden.cast.rays import Hits, Rays
from golden.cast.screen import Screen
from golden.scene.scene import Scene

__all__ = ["SpecularCaster", "SpecularScreen", "specular_screens"]

# Rays of a frustum, at least: it has patches of its own, which the machine loads.
_LEAST = 256
# Points are in one plane if their normals differ by less than this, and their places by less than this share of the
# scene's size.
_FLAT = 2.0**-32


@dataclass(frozen=True, kw_only=True, eq=False)
class SpecularScreen:
    """The rays of a picture that meet one plane.

    Parameters
    ----------
    rows
        Their numbers among the rays given.
    screen
        What they are rays of: the picture's, or the one of its mirrored eye.
    number
        Their numbers in it.
    patches
        The patches with a part beyond the plane, in order; none of a surface that the rays leave.
    """

    rows: np.ndarray
    screen: Screen
    number: np.ndarray
    patches: np.ndarray


def specular_screens(scene: Scene, screen: Screen, rays: Rays, field: np.ndarray, normal: np.ndarray, *,
                     is_mirrored: bool) -> Iterator[SpecularScreen]:
    """The screens behind planes that enough rays of a picture meet.

    Parameters
    ----------
    scene, screen
        The patches and the picture.
    rays
        K rays from where those of the picture meet flat patches.
    field
        K: their numbers in the picture.
    normal
        K x 3: these patches' unit normals on the side where the rays go on.
    is_mirrored
        Whether they are reflected, or go straight on.
    """
    size = np.ptp(scene.vertices.reshape(-1, 3), axis=0).max()
    offset = np.einsum("kj,kj->k", normal, rays.origin)
    key = np.rint(np.column_stack([normal, offset / size]) / _FLAT).astype(np.int64)
    order = np.lexsort(key.T)
    borders = np.flatnonzero((key[order[1:]] != key[order[:-1]]).any(axis=1)) + 1
    for rows in np.split(order, borders):
        if len(rows) < _LEAST:
            continue
        rows.sort()
        plane, place = normal[rows[0]], offset[rows].mean()
        depth = np.einsum("nvj,j->nv", scene.vertices, plane) - place
        # Patches that rays leave are planar only to rounding: a corner of theirs may be beyond the plane.
        is_left = np.isin(scene.surface, rays.source[rows])
        beyond = np.flatnonzero((depth.max(axis=1) > _FLAT * size) & ~is_left)
        row, column = np.divmod(field[rows], screen.width)
        camera = screen.camera
        if is_mirrored:
            eye, target = (np.array(point) - 2 * (np.dot(point, plane) - place) * plane
                           for point in (camera.eye, camera.target))
            camera = replace(camera, eye=eye, target=target, up=camera.up - 2 * np.dot(camera.up, plane) * plane)
            # Cameras are right-handed: what a mirror shows is turned around left and right.
            column = screen.width - 1 - column
        yield SpecularScreen(rows=rows, screen=replace(screen, camera=camera), number=row * screen.width + column,
                             patches=beyond)


class SpecularCaster:
    """Casts the rays of a picture behind flat mirrors and thin panes.

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

    def nearest(self, rays: Rays, field: np.ndarray, normal: np.ndarray, *,
                is_mirrored: bool) -> tuple[np.ndarray, Hits]:
        """The hits of rays of which enough meet one plane.

        Parameters
        ----------
        rays
            K rays from where those of the picture meet flat patches.
        field, normal, is_mirrored
            See `specular_screens`.

        Returns
        -------
        The numbers of the rays that are cast, and their hits.
        """
        found = []
        for one in specular_screens(self._oracle.scene, self._screen, rays, field, normal, is_mirrored=is_mirrored):
            patch, tests, steps = self._frusta.beyond(one.patches, one.screen, one.number) if len(one.patches) else (
                np.full(len(one.rows), -1), *np.zeros((2, len(one.rows)), dtype=np.int64))
            met = np.where(patch >= 0, one.patches[patch] if len(one.patches) else -1, -1)
            keep = ~self._is_before(rays, one.rows, met)
            found.append(np.stack([one.rows, met, tests, steps])[:, keep])
        rows, patch, tests, steps = np.concatenate([np.zeros((4, 0), dtype=np.int64), *found], axis=1)
        self.rays += len(rows)
        cast = Rays(rays.origin[rows], rays.direction[rows], rays.source[rows])
        return rows, hits_of_patches(self._oracle, cast, patch, tests=tests, steps=steps)

    def _is_before(self, rays, rows, patch):
        """Whether rays reach the plane of the patch that they are said to meet before they start: K bool."""
        scene, hit = self._oracle.scene, np.flatnonzero(patch >= 0)
        which, row = patch[hit], rows[hit]
        normal = scene.normals[which]
        height = np.einsum("kj,kj->k", normal, scene.vertices[which].mean(axis=1) - rays.origin[row])
        before = np.zeros(len(rows), dtype=bool)
        before[hit] = height * np.einsum("kj,kj->k", normal, rays.direction[row]) <= 0
        return before
