"""Why a ray that Embree casts may have another hit than the double-precision oracle gives it."""

from collections import Counter

import numpy as np

from golden.cast.outline import narrowest
from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["CAUSES", "float32_causes"]

CAUSES = ("start", "edge", "grazing", "crossing", "unexplained")

# In the scene's sizes: how near a start another patch is, how near to its border a hit, and how near to each other
# along the normal of the one are two patches; and the cosine of a patch that is seen edge-on.
_START, _EDGE, _APART, _GRAZING = 2.0**-16, 2.0**-17, 2.0**-19, 2.0**-8


def float32_causes(scene: Scene, rays: Rays, found: Hits, expected: Hits) -> Counter:
    """How many rays hit another patch than expected, by the first of `CAUSES`.

    *Start*: a hit is within float32's band of the ray's start. *Edge*: a hit is within the band of its patch's border.
    *Grazing*: the patch is seen edge-on. *Crossing*: the two patches are closer to each other there than the band.

    Parameters
    ----------
    scene, rays
        The patches, and R rays.
    found, expected
        Hits of R rays by Embree, and by a caster in double precision.
    """
    rows = np.flatnonzero(found.patch != expected.patch)
    rays = rays[rows]
    length = np.linalg.norm(rays.direction, axis=1)
    start, edge, grazing = np.zeros((3, len(rows)), dtype=bool)
    cosine = np.ones(len(rows))
    for hits in (found, expected):
        patch, u, v = hits.patch[rows], hits.u[rows], hits.v[rows]
        met = patch >= 0
        inner = np.where(scene.is_triangle[patch], np.minimum(np.minimum(u * (1 - v), (1 - u) * (1 - v)), v),
                         np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)))
        seen = np.abs(np.einsum("rj,rj->r", scene.normals[patch], rays.direction)) / length
        start |= met & (hits.t[rows] * length <= _START * scene.size)
        edge |= met & (inner * narrowest(scene)[patch] <= _EDGE * scene.size)
        grazing |= met & (seen <= _GRAZING)
        cosine = np.where(met, np.minimum(cosine, seen), cosine)
    with np.errstate(invalid="ignore"):
        apart = np.abs(found.t[rows] - expected.t[rows]) * length * cosine
    cause = np.select([start, edge, grazing, apart <= _APART * scene.size], range(4), 4)
    return Counter({name: int((cause == number).sum()) for number, name in enumerate(CAUSES)})
