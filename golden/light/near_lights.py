"""Finer elements where a surface is near to a light that shines on it."""

import numpy as np

from golden.cast.rays import Rays
from golden.light.surface_points import bilinear
from golden.scene.cuts import Cuts
from golden.scene.scene import Scene

__all__ = ["RESOLVED", "NearPairs", "near_knots"]

RESOLVED = 1 / 3
"""A light nearer than this share of an element's longest edge lights a strip that the element cannot resolve. At a
third, the light of a panel below a ceiling is about 1 % too bright."""
# Points along each side of a light that look for surfaces near it.
POINTS = 4
# The finest cut is at this share of the light's distance, but at least at this share of a uniform element; each
# further one doubles the distance from the edge of the light.
SHARE, LEAST = 0.5, 1 / 64
# A uniform cut nearer to a knot than this share of a uniform element is left out.
APART = 0.5
# Quads that are off a parallelogram by more than this share of their diagonal have no knots.
PARALLEL = 1e-9
# Most cells of a patch along one side.
MOST_CELLS = 256


class NearPairs:
    """Lights and the surfaces that points on them see straight ahead.

    Parameters
    ----------
    caster
        Casts rays from the lights.

    Members
    -------
    light, receiver
        K int: patches; a receiver reflects diffusely and does not emit.
    distance
        K float64.
    """

    def __init__(self, scene: Scene, caster):
        lights = np.flatnonzero(scene.channels("emission").any(axis=1))
        backs = lights[scene.two_sided[lights]]
        sides = np.repeat([1.0, -1.0], [len(lights), len(backs)])
        lights = np.concatenate([lights, backs])
        share = (np.arange(POINTS) + 0.5) / POINTS
        u, v = (grid.ravel() for grid in np.meshgrid(share, share))
        patch, side = np.repeat(lights, POINTS**2), np.repeat(sides, POINTS**2)
        origin = bilinear(scene.vertices[patch], np.tile(u, len(lights)), np.tile(v, len(lights)))
        hits = caster.nearest(Rays(origin, side[:, None] * scene.normals[patch], scene.surface[patch]))
        met = np.flatnonzero(hits.patch >= 0)
        facing = side[met] * np.einsum("kj,kj->k", scene.normals[patch[met]], scene.normals[hits.patch[met]]) < 0
        met = met[(facing | scene.two_sided[hits.patch[met]]) & scene.channels("diffuse").any(axis=1)[hits.patch[met]]]
        # Another light's own emission outshines what it reflects.
        met = met[~scene.channels("emission").any(axis=1)[hits.patch[met]]]
        self.light, self.receiver, self.distance = patch[met], hits.patch[met], hits.t[met]


def near_knots(scene: Scene, pairs: NearPairs, cuts: Cuts) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Knots, as `Cuts` takes them, of surfaces near to lights whose uniform ``cuts`` are too coarse: parallelograms.

    A receiver is cut at the edges of the light's projection along its normal, and beside them at distances that double
    from `SHARE` of the light's distance on, until they reach the uniform elements' size. A light that reflects is cut
    beside its own edges: what is between the two surfaces leaves there.
    """
    found: dict[int, list[tuple[np.ndarray, float]]] = {}
    for light, receiver in np.unique(np.stack([pairs.light, pairs.receiver]), axis=1).T.tolist():
        distance = pairs.distance[(pairs.light == light) & (pairs.receiver == receiver)].min()
        if distance >= RESOLVED * (_sizes(scene, receiver) / cuts.counts[receiver]).max():
            continue
        near = [(receiver, light)]
        if scene.channels("diffuse")[light].any():
            near.append((light, light))
        for patch, edges in near:
            if _is_parallelogram(scene.vertices[patch]):
                found.setdefault(patch, []).append((_places(scene.vertices[patch], scene.vertices[edges]), distance))
    knots = {}
    for patch, lights in found.items():
        sizes = _sizes(scene, patch)
        own = tuple(_graded(cuts.counts[patch, axis], [(places[axis], distance / sizes[axis])
                                                       for places, distance in lights]) for axis in (0, 1))
        if max(map(len, own)) <= MOST_CELLS + 1:
            knots[patch] = own
    return knots


def _sizes(scene, patch):
    """Lengths of a quad's edges along u and along v."""
    return np.linalg.norm(scene.vertices[patch][[1, 3]] - scene.vertices[patch][0], axis=1)


def _is_parallelogram(corners):
    off = np.linalg.norm(corners[2] - corners[1] - corners[3] + corners[0])
    return off <= PARALLEL * np.linalg.norm(corners[2] - corners[0])


def _places(corners, points):
    """2 x K: bilinear coordinates in a parallelogram of K points, projected along its normal."""
    axes = np.stack([corners[1] - corners[0], corners[3] - corners[0]], axis=1)
    return np.linalg.lstsq(axes, (points - corners[0]).T, rcond=None)[0]


def _graded(count, lights):
    """Knots along one axis from the places of the lights' corners, and the lights' distances, in units of the axis."""
    step = 1 / count
    kept = [0.0, 1.0]
    for places, distance in lights:
        finest = max(SHARE * distance, LEAST * step)
        for edge in (places.min(), places.max()):
            beside = finest * 2.0 ** np.arange(np.ceil(max(np.log2(step / finest), 0)))
            for place in (edge, *(edge + side * off for off in beside for side in (1, -1))):
                if 0 < place < 1 and min(abs(place - other) for other in kept) >= APART * finest:
                    kept.append(place)
    even = np.arange(1, count) * step
    apart = np.abs(even[:, None] - np.array(kept)).min(axis=1)
    return np.sort(np.concatenate([kept, even[apart >= APART * step]]))
