"""Light whose amount is known: closed forms and quadratures of definitions, and what the renderer measures."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from scipy.integrate import quad

from benchmarks.analytic import point_to_polygon
from benchmarks.daylight_room import (
    BLACK,
    EFFICACY,
    GLASS,
    LEVEL,
    OPENINGS,
    PLACES,
    SKIES,
    UP,
    VIEW,
    Case,
    at,
    daylit,
    luminance,
    received,
    room,
    through,
    transmittance,
)
from benchmarks.window_cases import VERTICAL, WINDOWS
from golden.light.photometry.quantities import lux
from golden.render.two_pass import RenderSettings, render
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.luminaires.photometric_web import PhotometricWeb
from golden.scene.material import Material
from golden.scene.sky.daylight import Daylight

__all__ = ["CASES"]

ROOF = OPENINGS["roof"]

def sky_component(sky: str, opening: str) -> Iterator[Case]:
    """Of a sky behind an unglazed opening."""
    hole = OPENINGS[opening]
    found = received(daylit(room(opening), sky), PLACES)
    for place, value in zip(PLACES, found, strict=True):
        truth = through(hole, place, luminance(sky))
        if sky == "uniform":  # Lambert's closed form
            truth = LEVEL * abs(point_to_polygon([place], [UP], [hole])[0, 0])
        yield Case(name=f"{sky} sky, opening in the {opening}, {at(place)}, lux", truth=truth, found=value)


def open_sky(sky: str) -> Iterator[Case]:
    """Of a sky without obstructions, on a horizontal and on a vertical plane."""
    builder = SceneBuilder("chip")
    builder.add(0.001 * (ROOF - ROOF.mean(axis=0)), BLACK)
    scene = Daylight(sky=sky, sky_illuminance=LEVEL, ground=0.0).scene(builder.build(), EFFICACY)
    for name, normal, share in (("horizontal", UP, 1.0), ("vertical", (0, -1, 0), VERTICAL[sky])):
        yield Case(name=f"{sky} sky, {name} plane in the open, lux", truth=share * LEVEL,
                   found=received(scene, [(0, 0, 1)], normal)[0])


def reflections(reflectance: float) -> Iterator[Case]:
    """Mean illuminance of a closed cube of one reflectance with a point light in it: its flux over A (1 - rho)."""
    builder = SceneBuilder("cube")
    builder.add(box((0, 0, 0), (2, 2, 2))[:, ::-1], Material(name="wall", diffuse=(reflectance,) * 3))
    flux = 4 * np.pi * 1000 / EFFICACY
    scene = builder.build(lights=(PointLight(position=(1, 1, 1), intensity=(1000 / EFFICACY,) * 3),))
    result = render(scene, camera=VIEW, settings=RenderSettings(
        width=1, height=1, samples=1, rays=(64, 16), max_edge=0.125))
    area = result.indirect.elements.area
    yield Case(name=f"cube of reflectance {reflectance:g}, mean over its faces, lux",
               truth=EFFICACY * flux / area.sum() / (1 - reflectance),
               found=area @ lux(result.indirect.received, EFFICACY) / area.sum())


def lamps() -> Iterator[Case]:
    """A point light and a square lamp above a plane."""
    places = np.array([(0.0, 0, 0), (1, 0, 0), (2, 2, 0)])
    floor, square = 4 * (ROOF - ROOF.mean(axis=0)), np.array([(-0.5, -0.5, 2.0), (-0.5, 0.5, 2), (0.5, 0.5, 2),
                                                              (0.5, -0.5, 2)])
    point, area = SceneBuilder("point"), SceneBuilder("area")
    point.add(floor[::-1], BLACK)
    area.add(square, Material(name="lamp", emission=(1000 / EFFICACY,) * 3))
    lit = point.build(lights=(PointLight(position=(0, 0, 2), intensity=(1000 / EFFICACY,) * 3),))
    factor = point_to_polygon(places, np.tile(UP, (3, 1)), [square])[:, 0]
    for name, scene, truths in (
            ("point light of 1000 cd", lit, [1000 * 2 / (place @ place + 4) ** 1.5 for place in places]),
            ("square lamp of 1000 cd/m2", area.build(), np.pi * 1000 * factor)):
        for place, truth, value in zip(places, truths, received(scene, places), strict=True):
            yield Case(name=f"{name} 2 above, {place[0]:g} x {place[1]:g} aside, lux", truth=truth, found=value)


def luminaire() -> Iterator[Case]:
    """A photometric web of 1000 cos(gamma) cd in steps of 5 degrees: its lumens, and a plane 2 below."""
    gamma = np.arange(0, 91, 5.0)
    web = PhotometricWeb(gamma=gamma, planes=[0], candela=[1000 * np.cos(np.radians(gamma))],
                         axes=[(1, 0, 0), (0, -1, 0), (0, 0, -1)])
    yield Case(name="luminaire of 1000 cos(gamma) cd, lumens", truth=1000 * np.pi, found=web.lumens)
    builder = SceneBuilder("luminaire")
    builder.add(4 * (ROOF - ROOF.mean(axis=0))[::-1], BLACK)
    scene = builder.build(lights=(PointLight(position=(0, 0, 2), intensity=(1 / EFFICACY,) * 3, web=web),))
    places = np.array([(0.0, 0, 0), (1, 0, 0), (2, 2, 0)])
    for place, value in zip(places, received(scene, places), strict=True):
        yield Case(name=f"luminaire 2 above, {place[0]:g} x {place[1]:g} aside, lux",
                   truth=1000 * 4 / (place @ place + 4) ** 2, found=value)


def glazing() -> Iterator[Case]:
    """The share of sunlight that passes a pane by its angle, and that of a uniform sky."""
    builder = SceneBuilder("pane")
    pane = np.array([(-5.0, -5, 1), (5, -5, 1), (5, 5, 1), (-5, 5, 1)]) * (1e3, 1e3, 1)
    builder.add(pane, GLASS, two_sided=True)
    for degrees in (0, 20, 40, 60, 70, 80):
        angle = np.radians(degrees)
        sun = DirectionalLight(direction=(0, np.sin(angle), -np.cos(angle)), irradiance=(100 / EFFICACY,) * 3)
        value = received(builder.build(lights=(sun,)), [(0, 0, 0)], settings={"max_edge": 1e5})[0]
        yield Case(name=f"pane, sun at {degrees} degrees, transmittance in %",
                   truth=100 * float(transmittance(np.cos(angle))), found=value / np.cos(angle))
    sky = Daylight(sky="uniform", sky_illuminance=100.0, ground=0.0).scene(builder.build(), EFFICACY)
    diffuse = quad(lambda angle: np.sin(2 * angle) * transmittance(np.cos(angle)), 1e-9, np.pi / 2 - 1e-9)[0]
    yield Case(name="pane, uniform sky, transmittance in %", truth=100 * diffuse,
               found=received(sky, [(0, 0, 0)], settings={"max_edge": 1e5})[0])


CASES: dict[str, Callable[[], Iterator[Case]]] = {
    **{f"{sky} sky": partial(open_sky, sky) for sky in VERTICAL},
    **{f"{opening}, {sky} sky": partial(sky_component, sky, opening) for opening in ("roof", "facade")
       for sky in SKIES},
    **WINDOWS,
    **{f"cube of {share:g}": partial(reflections, share) for share in (0.1, 0.5, 0.9)},
    "lamps": lamps, "luminaire": luminaire, "glazing": glazing}
"""By name what measures some cases."""
