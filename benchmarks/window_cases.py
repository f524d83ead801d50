"""Windows with glass, with a wall opposite, and light that one surface throws onto others."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from scipy.interpolate import RectBivariateSpline

from benchmarks.analytic import point_to_polygon
from benchmarks.daylight_room import (
    BLACK,
    EFFICACY,
    GLASS,
    LEVEL,
    OPENINGS,
    PLACES,
    Case,
    at,
    daylit,
    luminance,
    received,
    room,
    through,
    transmittance,
)
from golden.scene.builder import SceneBuilder
from golden.scene.lights import DirectionalLight
from golden.scene.material import Material

__all__ = ["VERTICAL", "WINDOWS"]

# The wall opposite the facade: its distance, height, extent along x and reflectance, and its largest element.
DISTANCE, HEIGHT, ACROSS, REFLECTANCE, ELEMENT = 3.0, 4.0, (-1.0, 8.0), 0.6, 0.5
FACADE = (0.0, 0.0), (4.0, 3.0)
# Illuminance of a vertical plane over that of the horizontal one, in the open above a black ground.
VERTICAL = {"uniform": 0.5, "cie-overcast": 3 * (np.pi / 2 + 4 / 3) / (7 * np.pi)}


def behind_glass(sky: str, opening: str) -> Iterator[Case]:
    """The sky component behind a pane in an opening."""
    hole, shine = OPENINGS[opening], _behind_pane(luminance(sky), opening)
    found = received(daylit(room(opening, (hole, GLASS)), sky), PLACES)
    for place, value in zip(PLACES, found, strict=True):
        yield Case(name=f"{sky} sky, pane in the {opening}, {at(place)}, lux", truth=through(hole, place, shine),
                   found=value)


def opposite(sky: str, *, glazed: bool) -> Iterator[Case]:
    """The externally reflected component of a facade: the light of a wall opposite, less that of a black one."""
    pane = ((OPENINGS["facade"], GLASS),) if glazed else ()
    low, high = ACROSS
    wall = np.array([(high, -DISTANCE, 0), (low, -DISTANCE, 0), (low, -DISTANCE, HEIGHT), (high, -DISTANCE, HEIGHT)])
    bright, dark = (received(daylit(room("facade", *pane, (wall, Material(name="wall", diffuse=(share,) * 3))), sky),
                             PLACES, settings={"max_edge": ELEMENT, "rays": (128, 32)}) for share in (REFLECTANCE, 0.0))
    shine = _wall_light(sky)
    if glazed:
        shine = _behind_pane(shine, "facade")
    for place, value in zip(PLACES, bright - dark, strict=True):
        yield Case(name=f"{sky} sky, wall opposite the {'pane' if glazed else 'opening'}, {at(place)}, lux",
                   truth=_from_wall(place, shine), found=value)


def lit_floor(*, obstructed: bool) -> Iterator[Case]:
    """A sunlit square of reflectance 0.8 that lights a wall and a ceiling, whole or half hidden by a partition."""
    square = np.array([(0.0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)])
    builder = SceneBuilder("floor")
    builder.add(square, Material(name="floor", diffuse=(0.8,) * 3))
    seen = square
    if obstructed:
        # The square is seen up to the partition, which is as high as the highest place and much wider.
        builder.add([(1.0, -50, 0), (1, 50, 0), (1, 50, 2), (1, -50, 2)], BLACK, two_sided=True)
        seen = np.array([(1.0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 2, 0)])
    sun = DirectionalLight(direction=(0, 0.5, -1), irradiance=(1000 / EFFICACY,) * 3)
    scene = builder.build(lights=(sun,))
    lit = 1000 / np.hypot(0.5, 1)
    for name, normal, places in (("wall", (-1.0, 0, 0), [(3, 1, 0.5), (3, 1, 2), (3, 0, 1)]),
                                 ("ceiling", (0.0, 0, -1), [(2.5, 1, 2), (3, 0, 2)])):
        places = np.array(places, dtype=np.float64)
        factor = point_to_polygon(places, np.tile(normal, (len(places), 1)), [seen])[:, 0]
        found = received(scene, places, normal, settings={"max_edge": 0.5})
        for place, share, value in zip(places, factor, found, strict=True):
            yield Case(name=f"{'half of a' if obstructed else 'a'} lit floor, {name} at ({place[0]:g}, {place[1]:g}, "
                            f"{place[2]:g}), lux", truth=0.8 * lit * share, found=value)


def _behind_pane(shine, opening):
    """What ``shine`` becomes behind a pane in an opening."""
    normal = {"roof": 2, "facade": 1}[opening]
    return lambda points, direction: shine(points, direction) * transmittance(np.abs(direction[:, normal]))


def _wall_light(sky):
    """The wall's radiosity, lux, by points of its plane's rays: from the facade's points and their directions."""
    x, z = np.linspace(*ACROSS, 49), np.linspace(0, HEIGHT, 33)
    shine = luminance(sky)
    lit = np.array([[VERTICAL[sky] * LEVEL - _hidden((one, -DISTANCE, height), shine) for height in z] for one in x])
    spline = RectBivariateSpline(x, z, REFLECTANCE * lit / np.pi)

    def shines(points, direction):
        meets = points - (points[:, 1:2] + DISTANCE) / direction[:, 1:2] * direction
        return spline(meets[:, 0], meets[:, 2], grid=False)

    return shines


def _hidden(place, shine):
    """Illuminance of the sky that the room hides from a point of the wall: that in its facade above the point."""
    (left, low), (right, high) = FACADE
    low = max(low, place[2])
    if low >= high:
        return 0.0
    facade = np.array([(left, 0, low), (right, 0, low), (right, 0, high), (left, 0, high)])
    return through(facade, np.asarray(place), shine, np.array((0.0, 1, 0)), points=32)


def _from_wall(place, shine):
    """Illuminance through the part of the opening in which a place on the floor sees the wall."""
    opening = OPENINGS["facade"]
    top = min(HEIGHT * place[1] / (place[1] + DISTANCE), opening[:, 2].max())
    part = opening.copy()
    part[:, 2] = np.minimum(part[:, 2], top)
    return through(part, place, shine)


WINDOWS: dict[str, Callable[[], Iterator[Case]]] = {
    **{f"pane in the {opening}, {sky} sky": partial(behind_glass, sky, opening) for opening in OPENINGS
       for sky in VERTICAL},
    **{f"wall opposite, {sky} sky, {kind}": partial(opposite, sky, glazed=kind == "pane") for sky in VERTICAL
       for kind in ("opening", "pane")},
    "lit floor": partial(lit_floor, obstructed=False), "half a lit floor": partial(lit_floor, obstructed=True)}
"""By name what measures some cases."""
