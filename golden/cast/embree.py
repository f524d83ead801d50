"""Casting with Embree, whose finds are judged in float64."""

import ctypes

import numpy as np

from golden.base.errors import InputError
from golden.base.stage_progress import StageProgress
from golden.cast.embree_library import embree_library, has_embree
from golden.cast.oracle import Oracle
from golden.cast.outline import narrowest, widened
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["Embree"]

# In the scene's sizes: how far rays start above their sources, and how far behind that Embree begins; how far behind
# their starts others begin; how far patches are widened; and by how much less deep than another a hit is if Embree
# separates them.
RISE, BACK, BEFORE, WIDTH, SLACK = 2.0**-23, 2.0**-25, 2.0**-17, 2.0**-19, 2.0**-16
# How close above a patch another one is that may be at the start of a ray, and by how much patches reach over each
# other that just meet.
BAND, TOUCH = 2.0**-18, 2.0**-20
# How far from a plane patches are that lie in it, in least distances of hits.
PLANE = 0.0625
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
    counts where it is as far again within the patch. If it is nearer to the border, or to the ray's start, or another
    patch lies upon this one, every patch that Embree finds along the ray is judged by the oracle's test; and of a ray
    that passes beside one of them, every patch up to its end is. So no ray leaks through edges, and of equally near
    patches the first one wins.

    A ray starts 2^-23 above its source, so that Embree does not find that. Where another patch lies along the source,
    closer than 2^-18, or the ray has no source, it begins 2^-17 before its start instead, and what Embree finds there
    is judged. What may remain are differences where float32 does not separate two patches: a hit as near to a line
    where patches cross or touch, a start as near to a patch that is not along its own, a patch seen edge-on.

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
        There is no wheel of embreex.
    InputError
        Jobs out of range, float64 does not resolve the scene, or the compiler is switched off.
    """

    def __init__(self, scene: Scene, *, jobs: int | None = None, progress: bool = False):
        embree_library()
        if not has_embree():
            raise InputError("Method embree needs numba's compiler, which NUMBA_DISABLE_JIT switches off")
        from golden.cast import embree_kernel, near_kernel
        from golden.cast.embree_scene import EmbreeScene

        super().__init__(jobs)
        self.oracle, self._kernel, self._near = Oracle(scene), embree_kernel, near_kernel
        with StageProgress("embree", EXPECTED, shown=progress) as bar:
            with bar.stage("patches"):
                self._scene = EmbreeScene((widened(scene, WIDTH * scene.size) - scene.bounds.mean(axis=0)) / scene.size)
            with bar.stage("compiling"):
                self._model = self._modelled(scene)
                self.nearest(Rays(np.empty((0, 3)), np.empty((0, 3))))

    def _modelled(self, scene):
        library, kernel = embree_library(), self._kernel
        nearest, together, blocked, around = (ctypes.cast(query, ctypes.c_void_p).value for query in (
            library.rtcIntersect1, library.rtcIntersect8, library.rtcOccluded1, library.rtcPointQuery))
        centre, least = scene.bounds.mean(axis=0), self.oracle.nearest
        near, boxes = np.empty(len(scene), dtype=np.uint8), np.empty((len(scene), 6))
        self._near.find_near(around, self._near.compare.address, self._scene.address, centre, scene.size,
                             scene.vertices, scene.normals, BAND * scene.size, PLANE * least, TOUCH * scene.size, near,
                             boxes)
        surfaces = int(max(scene.surface.max(), 0)) + 1
        rises, zones = np.zeros((surfaces, 4), dtype=np.float32), np.full((surfaces, 6), np.inf)
        rises[scene.surface, :3], zones[:, 3:] = RISE * scene.normals, -np.inf
        for kind, note in ((self._near.OVER, kernel.LOW_FRONT), (self._near.UNDER, kernel.LOW_BACK)):
            rises[np.unique(scene.surface[near & kind != 0]), 3] += note
        np.minimum.at(zones[:, :3], scene.surface, boxes[:, :3] - BAND * scene.size)
        np.maximum.at(zones[:, 3:], scene.surface, boxes[:, 3:] + BAND * scene.size)
        # The model has their addresses.
        self._arrays = scene.vertices, _fields(scene, near & self._near.UPON != 0), rises, zones, scene.normals
        x, y, z = centre.tolist()
        vertices, patches, rises, zones, normals = (one.ctypes.data for one in self._arrays)
        return kernel.Model(
            nearest=nearest, together=together, blocked=blocked, judge=kernel.judge.address, scene=self._scene.address,
            x=x, y=y, z=z, size=scene.size, back=BACK, before=BEFORE, slack=SLACK, least=float(least), count=len(scene),
            surfaces=surfaces, vertices=vertices, patches=patches, rises=rises, zones=zones, normals=normals,
            behind=0 if scene.behind is None else scene.behind.ctypes.data)

    def nearest(self, rays: Rays) -> Hits:
        """See the base class."""
        return self._cast(rays, any_hit=False)

    _nearest = nearest

    def any_hit(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``."""
        return self._cast(rays, any_hit=True)

    def blocked(self, rays: Rays) -> np.ndarray:
        """Whether each ray hits anything before its ``tmax``, R bool."""
        return self._patches(rays, True, *np.empty((3, 0))) >= 0

    def nearest_patches(self, rays: Rays) -> np.ndarray:
        """See the base class."""
        return self._patches(rays, False, *np.empty((3, 0)))

    def _patches(self, rays, any_hit, t, u, v):
        """The patch that each ray hits; where is written to the last three arguments, unless they are empty."""
        self.oracle.check(rays)
        patch = np.empty(len(rays), dtype=np.int32)

        def part(rows):
            self._kernel.cast(self._model, any_hit, rays.origin[rows], rays.direction[rows], rays.source[rows],
                              rays.target[rows], rays.tmax[rows], patch[rows], t[rows], u[rows], v[rows])

        self._in_threads(part, len(rays), least=FEWEST, shares=SHARES * self.jobs)
        return patch

    def _cast(self, rays, *, any_hit):
        count = len(rays)
        t, u, v = np.empty((3, count))
        patch = self._patches(rays, any_hit, t, u, v)
        unknown = np.zeros(count, dtype=np.int64)
        return Hits(patch=patch, t=t, u=u, v=v, tests=unknown, steps=unknown)


def _fields(scene, judged):
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
    fields[judged, 2] = 1
    return fields
