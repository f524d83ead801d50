"""Light in a scene that the two passes do not compute."""

import numpy as np

from golden.base.input_warnings import warn
from golden.base.plural import counted
from golden.light.glass import Glass
from golden.light.near_lights import RESOLVED, NearPairs
from golden.scene.overlaps import overlaps
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["not_computed", "warn_of_flush_lights", "warn_of_near_lights", "warn_of_tiny_patches"]

# Patches smaller than so many of the least distances of a hit lose rays that start beside them.
TINY = 16

# Materials that a line names.
_MOST_NAMES = 3


def not_computed(scene: Scene, *, has_buried: bool) -> list[str]:
    """What is missing in an image of the scene, what that means, and what helps: one line each.

    Parameters
    ----------
    has_buried
        Whether parts of curved surfaces are inside bodies.
    """
    glass = Glass(scene)
    mirrors = scene.channels("specular").any(axis=1)
    panes = glass.clear & ~glass.throws & (scene.channels("refraction_index") > 1)
    bent = glass.clear & ~glass.thin & (scene.channels("refraction_index") > 1) & scene.is_curved
    missing = []
    unlit = mirrors & glass.mirrors & bool(scene.lights)
    if unlit.any():
        missing.append(f"spots of light that {_named(scene, unlit)} throw of lights without an area: it is spread "
                       "evenly; lamps with an area throw spots")
    if (mirrors & ~glass.mirrors).any():
        missing.append(f"spots of light that {_named(scene, mirrors & ~glass.mirrors)} throw: what they mirror is "
                       "spread evenly; flat mirrors of at least half of the light throw spots")
    if panes.any():
        missing.append(f"spots of light that glass mirrors, {_named(scene, panes)}: some per cent of the light are "
                       "spread evenly; flat thin sheets, and lamps with an area, throw such spots")
    if bent.any():
        missing.append(f"light that curved glass bends, {_named(scene, bent)}: it goes straight, so that no bright "
                       "spots but even shadows are beside it; a path tracer has them")
    if scene.is_curved.any():
        edges = scene.vertices[scene.is_curved] - np.roll(scene.vertices[scene.is_curved], 1, axis=1)
        missing.append(f"edges of light on smooth surfaces finer than their facets, {_named(scene, scene.is_curved)}: "
                       f"shadows end in steps of up to {np.linalg.norm(edges, axis=2).max():.2g}; finer facets in the "
                       "file help")
    if has_buried:
        missing.append("light along the lines where curved bodies enter others: it is too dark within an element of "
                       "them; a smaller --max-edge, or bodies that end where they meet others, helps")
    return missing


def _named(scene, chosen):
    """Materials of patches, and their share of all area."""
    names = [scene.materials[number].name for number in np.unique(scene.material[chosen])]
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    share = scene.areas[chosen].sum() / scene.areas.sum()
    return f"{', '.join(map(repr, names[:_MOST_NAMES]))}{more} ({share:.2g} of the area)"


def warn_of_flush_lights(scene: Scene) -> None:
    """Name the first light that lies in the plane of a surface which it covers; one `InputWarning` at most."""
    emits = scene.channels("emission").any(axis=1)
    pairs = overlaps(scene, emits)
    if len(pairs):
        first = pairs[0][np.argsort(~emits[pairs[0]])]
        light, surface = (scene.materials[number].name for number in scene.material[first])
        more = f", and {counted(len(pairs) - 1, 'more pair')}" if len(pairs) > 1 else ""
        warn(f"scene {scene.name!r}: a light of material {light!r} lies in a surface of material "
             f"{surface!r}{more}: rays meet either of them; a small distance helps")


def warn_of_tiny_patches(scene: Scene, least: float) -> None:
    """Name how many patches are too small beside the scene for rays to resolve them; one `InputWarning` at most.

    Parameters
    ----------
    least
        Least distance of a hit, in scene units.
    """
    extent = (scene.vertices.max(axis=1) - scene.vertices.min(axis=1)).max(axis=1)
    tiny = np.count_nonzero(extent < TINY * least)
    if tiny:
        warn(f"scene {scene.name!r}: {counted(tiny, 'patch')} of {len(scene)} smaller than "
             f"{TINY * least:.3g}, which rays miss in a scene of {scene.size:.3g}: is a vertex astray?")


def warn_of_near_lights(scene: Scene, refinement: Refinement, pairs: NearPairs) -> None:
    """Name the nearest surface that is too near to a light for its elements; one `InputWarning` at most.

    Parameters
    ----------
    pairs
        The lights, and the surfaces before them. One with knots is cut where the light demands it.
    """
    edges = refinement.scene.vertices
    longest = np.linalg.norm(edges - np.roll(edges, 1, axis=1), axis=2).max(axis=1)[refinement.first]
    share = pairs.distance / longest[pairs.receiver]
    near = np.flatnonzero((share < RESOLVED) & ~refinement.cuts.has_knots(pairs.receiver))
    if len(near):
        worst = near[np.argmin(share[near])]
        name, length = scene.materials[scene.material[pairs.light[worst]]].name, longest[pairs.receiver[worst]]
        warn(f"scene {scene.name!r}: a light of material {name!r} is {pairs.distance[worst]:.3g} from a "
             f"surface whose elements are {length:.3g} long: the light that the surface reflects may be too "
             "bright; a smaller --max-edge helps")
