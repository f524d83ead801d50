"""Casting with Embree, whose finds are judged in float64."""

import ctypes
from dataclasses import replace
from functools import cached_property
from importlib import import_module

import numpy as np

from golden.cast.embree_library import embree_library, has_embree
from golden.cast.outline import narrowest, widened
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.errors import InputError
from golden.oracle import Oracle
from golden.scene.overlaps import overlaps
from golden.scene.scene import Scene
from golden.stage_progress import StageProgress

__all__ = ["Embree"]

# In the scene's sizes: how far rays start above their sources, and how far behind that hits may be; how far patches
# are widened; and by how much less deep than another a hit is if Embree separates them.
RISE, BACK, WIDTH, SLACK = 2.0**-23, 2.0**-24, 2.0**-19, 2.0**-16
# How near another patch is that may be at the start of a ray: lattice nodes are 2^-19 away from the borders of theirs.
REACH = 2.0**-22
# Least rays of a compiled call, and calls per thread.
FEWEST, SHARES = 1 << 12, 8
# Seconds of the stages of the first caster of all, nearly all of them compilation.
EXPECTED = {"patches": 1, "compiling": 6}


class Embree(RayCaster):
    """Casts with the hits of `golden.cast.grid.Grid`: Embree finds the patches in float32, float64 judges them.

    The band of float32: with the scene's middle at the origin and its size 1 a coordinate is at most 0.5 and rounds by
    2^-26. The rounding of a ray's start, of its direction over a length of up to 2, of the corners, and of Embree's
    differences, products and sums of them each moves an edge, as the ray sees it, by at most 2^-24 or twice that:
    together by less than 2^-21.

    Embree has each patch 2^-19 wider on all sides than it is, so that a ray between two patches meets both. A hit
    counts where it is as far again within the patch. If it is nearer to the border, or the patch overlaps another one
    in its plane, every patch that Embree finds along the ray is judged by the oracle's test; and a ray that passed
    beside one of them is cast by grid. So no ray leaks through edges, and of equally near patches the first one wins.

    A ray starts 2^-23 above its source. What may remain are differences where float32 does not separate two patches: a
    ray that meets two of one depth, farther than the band from the border of one, or starts that near to another patch.

    Parameters
    ----------
    scene
        The patches.
    jobs
        Threads, at least 1; the hits do not depend on it. Default: one per processor that this process may use.
    progress
        Shows a progress bar after two seconds of preparation: the first caster of all compiles the code.

    Raises
    ------
    ModuleNotFoundError
        There is no wheel of embreex, or no numba.
    InputError
        Jobs out of range, float64 does not resolve the scene, or the compiler is switched off.
    """

    def __init__(self, scene: Scene, *, jobs: int | None = None, progress: bool = False):
        embree_library()
        if not has_embree():
            import_module("numba")
            raise InputError("Method embree needs numba's compiler, which NUMBA_DISABLE_JIT switches off")
        from golden.cast import embree_kernel
        from golden.cast.embree_scene import EmbreeScene

        super().__init__(jobs)
        self.oracle, self._kernel = Oracle(scene), embree_kernel
        with StageProgress("embree", EXPECTED, shown=progress) as bar:
            with bar.stage("patches"):
                self._scene = EmbreeScene((widened(scene, WIDTH * scene.size) - scene.bounds.mean(axis=0)) / scene.size)
            with bar.stage("compiling"):
                self._model = self._modelled(scene)
                self.nearest(Rays(np.empty((0, 3)), np.empty((0, 3))))

    def _modelled(self, scene):
        library, kernel = embree_library(), self._kernel
        nearest, blocked, around = (ctypes.cast(query, ctypes.c_void_p).value for query in (
            library.rtcIntersect1, library.rtcOccluded1, library.rtcPointQuery))
        normals = np.zeros((max(scene.surface.max(), 0) + 1, 3))
        normals[scene.surface] = scene.normals
        return kernel.Model(
            nearest=nearest, blocked=blocked, around=around, judge=kernel.judge.address, find=kernel.find.address,
            scene=self._scene.address,
            centre=scene.bounds.mean(axis=0), size=scene.size, rise=RISE, back=BACK, slack=SLACK, reach=REACH,
            least=self.oracle.nearest, vertices=scene.vertices, patches=_fields(scene), normals=normals)

    @cached_property
    def _grid(self):
        """The caster of rays that Embree leaves undecided."""
        from golden.cast.shared_caster import shared_caster  # which imports this module

        return shared_caster(self.oracle.scene, "grid", self.jobs)

    def _nearest(self, rays):
        return self._cast(rays, any_hit=False)

    def any_hit(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``."""
        return self._cast(rays, any_hit=True)

    def blocked(self, rays: Rays) -> np.ndarray:
        """Whether each ray hits anything before its ``tmax``, R bool."""
        patch, rows = self._patches(rays, True, *np.empty((3, 0)))
        patch[rows] = self._grid.any_hit(rays[rows]).patch if len(rows) else -1
        return patch >= 0

    def _patches(self, rays, any_hit, t, u, v):
        """The patch that each ray hits, and the rows of the rays that are undecided."""
        self.oracle.check(rays)
        patch = np.empty(len(rays), dtype=np.int32)

        def part(rows):
            self._kernel.cast(self._model, any_hit, rays.origin[rows], rays.direction[rows], rays.source[rows],
                              rays.target[rows], rays.tmax[rows], patch[rows], t[rows], u[rows], v[rows])

        self._in_threads(part, len(rays), least=FEWEST, shares=SHARES * self.jobs)
        return patch, np.flatnonzero(patch == self._kernel.UNDECIDED)

    def _cast(self, rays, *, any_hit):
        count = len(rays)
        t, u, v = np.empty((3, count))
        patch, rows = self._patches(rays, any_hit, t, u, v)
        if len(rows):
            hits = self._grid.any_hit(rays[rows]) if any_hit else self._grid.nearest(rays[rows])
            patch[rows], t[rows], u[rows], v[rows] = hits.patch, hits.t, hits.u, hits.v
        unknown = np.zeros(count, dtype=np.int64)
        return Hits(patch=patch, t=t, u=u, v=v, tests=unknown, steps=unknown)


def _fields(scene):
    """See `golden.cast.embree_kernel.Model`."""
    a, b, c = (scene.vertices[:, corner] - scene.vertices[:, 0] for corner in (1, 2, 3))
    normal = np.maximum(*(np.linalg.norm(np.cross(one, other), axis=1) for one, other in ((a, b), (b, c))))
    fields = np.empty((len(scene), 4), dtype=np.float32)
    fields.view(np.int32)[:, 0] = scene.surface
    fields[:, 1] = scene.is_triangle
    # Of a direction whose largest component is 1 the length is at most 2.
    with np.errstate(divide="ignore", over="ignore"):
        share = 2 * WIDTH * scene.size / narrowest(scene)
        fields[:, 2] = np.minimum(share, 1)
        fields[:, 3] = np.minimum(2 * share * (normal / scene.size**2), 1e30)
    # Whichever way they face.
    fields[overlaps(replace(scene, two_sided=np.ones(len(scene), dtype=bool))).reshape(-1), 2] = 1
    return fields
