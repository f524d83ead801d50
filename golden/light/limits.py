"""Light in a scene that the two passes do not compute."""

import warnings

import numpy as np

from golden.cast.rays import Rays
from golden.errors import InputWarning
from golden.light.glass import Glass
from golden.light.surface_points import bilinear
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["not_computed", "warn_of_near_lights"]

# A light nearer than this share of an element's longest edge lights a strip that the element cannot resolve. At a
# third, the light of a panel below a ceiling is about 1 % too bright.
RESOLVED = 1 / 3
# Points along each side of a light that look for surfaces near it.
POINTS = 4


def not_computed(scene: Scene, *, has_buried: bool) -> list[str]:
    """What is missing in an image of the scene, one line each; ``has_buried``: parts of surfaces are inside bodies."""
    glass = Glass(scene)
    mirrors = scene.channels("specular").any(axis=1)
    bodies = glass.clear & ~glass.thin & (scene.channels("refraction_index") > 1)
    missing = []
    if mirrors.any():
        missing.append("light that mirrors throw onto surfaces (it counts as diffuse)")
    if (bodies & scene.is_curved).any():
        missing.append("light that curved glass bends onto surfaces (it goes straight)")
    if scene.is_curved.any():
        missing.append("edges of light on smooth surfaces finer than their facets")
    if has_buried:
        missing.append("light along the lines where bodies interpenetrate (it is too dark)")
    return missing


def warn_of_near_lights(scene: Scene, refinement: Refinement, caster) -> None:
    """Name the nearest surface that is too near to a light for its elements; one `InputWarning` at most.

    Parameters
    ----------
    scene, refinement
        The patches and their elements.
    caster
        Casts rays from the lights.
    """
    lights = np.flatnonzero(scene.channels("emission").any(axis=1))
    if not len(lights):
        return
    sides = np.concatenate([np.ones(len(lights)), -np.ones(scene.two_sided[lights].sum())])
    lights = np.concatenate([lights, lights[scene.two_sided[lights]]])
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
    edges = refinement.scene.vertices
    longest = np.linalg.norm(edges - np.roll(edges, 1, axis=1), axis=2).max(axis=1)[refinement.first]
    ratio = hits.t[met] / longest[hits.patch[met]]
    near = met[ratio < RESOLVED]
    if len(near):
        worst = near[np.argmin(hits.t[near] / longest[hits.patch[near]])]
        name, length = scene.materials[scene.material[patch[worst]]].name, longest[hits.patch[worst]]
        warnings.warn(f"scene {scene.name!r}: a light of material {name!r} is {hits.t[worst]:.3g} from a surface whose "
                      f"elements are {length:.3g} long: the light that the surface reflects may be too bright; a "
                      "smaller --max-edge helps", InputWarning, stacklevel=2)
