"""Ray shading: the colour of a hit and the rays that it spawns, none of which anybody waits for."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.columns import Child, Ray
from radiosity.machines.torus.torus_scene import AMBIENT, DIFFUSE, INDEX, MIRROR, TRANSPARENT, Objects

__all__ = ["Spawned", "light_distance", "shade", "spawned"]

_AIR = -1


class Spawned(NamedTuple):
    """What a hit spawns; `shade` overwrites it.

    Parameters
    ----------
    rays, numbers
        Of each child, see `Ray` and `Child`.
    colour
        3 float64: what returns to the host.
    """

    rays: np.ndarray
    numbers: np.ndarray
    colour: np.ndarray


def spawned(lights: int) -> Spawned:
    """Capacity for the children of any hit: a shadow ray for each light, a mirrored and a refracted ray."""
    return Spawned(np.zeros((lights + 2, Ray.END)), np.zeros((lights + 2, len(Child)), dtype=np.int64), np.zeros(3))


@compiled
def light_distance(lights: np.ndarray, light: int, origin: np.ndarray, direction: np.ndarray) -> float:
    """Distance along a ray to the sphere of a light, infinite without a hit."""
    along = square = 0.0
    for axis in range(3):
        to = lights[light, axis] - origin[axis]
        along += to * direction[axis]
        square += to * to
    radius = lights[light, 3]
    root = along * along - square + radius * radius
    if radius <= 0 or root < 0 or along - np.sqrt(root) <= 0:
        return np.inf
    return along - np.sqrt(root)


@compiled
def shade(objects: Objects, ray: np.ndarray, level: int, medium: int, number: int, distance: float, deepest: int,
          least: float, has_shadows: bool, out: Spawned) -> int:
    """Shade a hit.

    The ambient term is added to the ray's colour; so are diffuse terms, if there are no shadows. Else a shadow ray
    carries each light's term, unless it is black. The colour moves to the first child, mirrored before refracted, and
    returns to the host if there is none: no colour is copied. A child that is too deep or contributes too little is not
    made, so what it would have carried returns.

    Parameters
    ----------
    objects
        Objects and lights.
    ray
        Its numbers; its colour is changed.
    level, medium
        Its ancestors, and the object that it is in.
    number, distance
        The object, and where it is hit.
    deepest, least
        Largest level, and least contribution in any channel, of a child.
    has_shadows
        Whether shadow rays are cast.
    out
        Overwritten: children, and the colour that returns.

    Returns
    -------
    Children.

    Source: Pearce 1987, section 3.4. It has no formulas of shading, and no least contribution.
    """
    normal, point, toward = np.zeros(3), np.zeros(3), np.zeros(3)
    direction = ray[Ray.DIRECTION:Ray.DIRECTION + 3]
    values, is_sphere = objects.coefficients[number], objects.counts[number] == 0
    slope = 0.0
    for axis in range(3):
        point[axis] = ray[Ray.ORIGIN + axis] + distance * direction[axis]
        if is_sphere:
            normal[axis] = (point[axis] - objects.corners[number, 0, axis]) / objects.corners[number, 1, 0]
        else:
            normal[axis] = objects.normals[number, axis]
        slope += normal[axis] * direction[axis]
    if slope > 0:
        slope = -slope
        for axis in range(3):
            normal[axis] = -normal[axis]
    for channel in range(3):
        ray[Ray.COLOUR + channel] += ray[Ray.CONTRIBUTION + channel] * values[AMBIENT + channel]
    children = _light(objects, ray, point, normal, level, medium, number, has_shadows, out)
    has_colour = ray[Ray.COLOUR] != 0 or ray[Ray.COLOUR + 1] != 0 or ray[Ray.COLOUR + 2] != 0
    for kind in (MIRROR, TRANSPARENT):
        child, most = out.rays[children], 0.0
        for channel in range(3):
            child[Ray.CONTRIBUTION + channel] = ray[Ray.CONTRIBUTION + channel] * values[kind + channel]
            most = max(most, child[Ray.CONTRIBUTION + channel])
        if level + 1 > deepest or not most > least:
            continue
        beyond = medium
        if kind == MIRROR:
            for axis in range(3):
                toward[axis] = direction[axis] - 2 * slope * normal[axis]
        else:
            ratio = 1.0
            if is_sphere:
                ratio = values[INDEX] if medium == number else 1 / values[INDEX]
                beyond = _AIR if medium == number else number
            root = 1 - ratio * ratio * (1 - slope * slope)
            if root < 0:
                continue
            turn = -ratio * slope - np.sqrt(root)
            for axis in range(3):
                toward[axis] = ratio * direction[axis] + turn * normal[axis]
        _start(child, point, toward)
        child[Ray.LIMIT] = np.inf
        for channel in range(3):
            child[Ray.COLOUR + channel] = ray[Ray.COLOUR + channel] if has_colour else 0.0
        has_colour = False
        out.numbers[children, Child.LEVEL], out.numbers[children, Child.MEDIUM] = level + 1, beyond
        out.numbers[children, Child.IS_SHADOW] = 0
        children += 1
    for channel in range(3):
        out.colour[channel] = ray[Ray.COLOUR + channel] if has_colour else 0.0
    return children


@compiled
def _light(objects, ray, point, normal, level, medium, number, has_shadows, out):
    """Add the diffuse terms of all lights to a ray, or make shadow rays that carry them: how many."""
    toward, values, children = np.zeros(3), objects.coefficients[number], 0
    for light in range(len(objects.lights)):
        cosine = square = 0.0
        for axis in range(3):
            toward[axis] = objects.lights[light, axis] - point[axis]
            square += toward[axis] * toward[axis]
        far = np.sqrt(square)
        for axis in range(3):
            toward[axis] /= far
            cosine += toward[axis] * normal[axis]
        if not cosine > 0:
            continue
        child, brightest = out.rays[children], 0.0
        for channel in range(3):
            term = (ray[Ray.CONTRIBUTION + channel] * values[DIFFUSE + channel] * cosine
                    * objects.lights[light, 4 + channel])
            if has_shadows:
                child[Ray.COLOUR + channel] = term
                brightest = max(brightest, term)
            else:
                ray[Ray.COLOUR + channel] += term
        if brightest > 0:
            _start(child, point, toward)
            child[Ray.LIMIT] = far
            for channel in range(3):
                child[Ray.CONTRIBUTION + channel] = 0.0
            out.numbers[children, Child.LEVEL], out.numbers[children, Child.MEDIUM] = level + 1, medium
            out.numbers[children, Child.IS_SHADOW] = 1
            children += 1
    return children


@compiled
def _start(child, point, direction):
    """A ray begins at a point, with a direction of unit length."""
    square = 0.0
    for axis in range(3):
        square += direction[axis] * direction[axis]
    length = np.sqrt(square)
    for axis in range(3):
        child[Ray.ORIGIN + axis] = point[axis]
        child[Ray.DIRECTION + axis] = direction[axis] / length
    child[Ray.ENTRY] = 0.0
