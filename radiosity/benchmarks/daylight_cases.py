"""Light whose amount is known: closed forms and quadratures of definitions, and what the renderer measures."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.integrate import dblquad, quad

from golden.light.analytic import point_to_polygon
from golden.light.photometry.quantities import lux
from golden.light.photometry.sensors import Sensors
from golden.light.two_pass import RenderSettings, render
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import FACES, box
from golden.scene.camera import Camera
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.luminaires.photometric_web import PhotometricWeb
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.sky.daylight import Daylight
from golden.scene.sky.distributions import Distribution, cie_clear, cie_overcast, horizontal, uniform

__all__ = ["CASES", "Case"]

UP = (0.0, 0.0, 1.0)
BLACK = Material(name="black")
# A room of 4 x 6 x 3, and its openings: in the middle of the roof, and in the wall to the south.
ROOM = np.array((4.0, 6.0, 3.0))
ROOF = np.array([(1.5, 2.0, 3), (1.5, 4, 3), (2.5, 4, 3), (2.5, 2, 3)])
FACADE = np.array([(1.0, 0, 1), (1, 0, 2.5), (3, 0, 2.5), (3, 0, 1)])
PLACES = np.array([(2.0, 3, 0), (1, 1.5, 0), (0.5, 3.5, 0), (3.5, 5.5, 0)])
LEVEL, SUN, EFFICACY = 10_000.0, (200.0, 40.0), 179.0
SKIES: dict[str, Callable[[], Distribution]] = {"uniform": uniform, "cie-overcast": cie_overcast,
                                                "cie-clear": cie_clear}
VIEW = Camera(eye=(1, 1, 1.5), target=(2, 3, 0), up=UP)


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is measured, the truth and the renderer's value."""

    name: str
    truth: float
    found: float

    @property
    def error(self) -> float:
        """Difference from the truth, relative to it."""
        return self.found / self.truth - 1


def _received(scene, places, normal=UP, *, settings=None):
    """Lux at places that face one way."""
    settings = {"width": 1, "height": 1, "samples": 1, "light_samples": 64, "rays": (64, 16), "max_edge": 9.0} | (
        settings or {})
    places = np.asarray(places, dtype=np.float64)
    result = render(scene, camera=VIEW, settings=RenderSettings(**settings),
                    sensors=Sensors(position=places, normal=np.tile(normal, (len(places), 1))))
    return lux(result.sensors, EFFICACY)


def _frame(opening, outer):
    """The four trapezoids between a rectangle and one around it, both from the same corner on."""
    return np.array([[outer[k], outer[k - 3], opening[k - 3], opening[k]] for k in range(4)])


def _room(roof=None, facade=None) -> Scene:
    """A black room with openings."""
    builder = SceneBuilder("room")
    faces = box((0, 0, 0), ROOM)[:, ::-1]
    for face, patch in zip(FACES, faces, strict=True):
        opening = {"+z": roof, "-y": facade}.get(face)
        if opening is None:
            builder.add(patch, BLACK, two_sided=True)
            continue
        outer = patch[np.argmin(np.linalg.norm(patch[:, None] - opening[None], axis=2), axis=0)]
        builder.add(_frame(opening, outer), BLACK, two_sided=True)
    return builder.build()


def _toward_sun():
    azimuth, elevation = np.radians(SUN)
    return np.array((np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)))


def _through(opening, place, distribution):
    """Illuminance of a sky through a rectangle at a point that faces up, by quadrature of the definition."""
    along, across = opening[1] - opening[0], opening[3] - opening[0]
    area, sun = np.cross(along, across), _toward_sun()
    scale = LEVEL / horizontal(distribution, np.arccos(sun[2]))

    def density(v, u):
        toward = opening[0] + u * along + v * across - place
        distance = np.linalg.norm(toward)
        direction = toward / distance
        if direction[2] <= 0:
            return 0.0
        relative = distribution(direction[2], np.arccos(np.clip(direction @ sun, -1, 1)))
        return relative * direction[2] * abs(direction @ area) / distance**2

    return scale * dblquad(density, 0, 1, 0, 1, epsrel=1e-7)[0]


def sky_component(sky: str, opening: str) -> Iterator[Case]:
    """Of a sky behind an unglazed opening."""
    hole = {"roof": ROOF, "facade": FACADE}[opening]
    scene = Daylight(sky=sky, sun=SUN, sky_illuminance=LEVEL, sun_illuminance=0.0, ground=0.0).scene(
        _room(**{opening: hole}), EFFICACY)
    found = _received(scene, PLACES)
    for place, value in zip(PLACES, found, strict=True):
        truth = _through(hole, place, SKIES[sky]())
        if sky == "uniform":  # Lambert's closed form
            truth = LEVEL * abs(point_to_polygon([place], [UP], [hole])[0, 0])
        yield Case(name=f"{sky} sky, opening in the {opening}, at ({place[0]:g}, {place[1]:g}), lux", truth=truth,
                   found=value)


def open_sky(sky: str) -> Iterator[Case]:
    """Of a sky without obstructions, on a horizontal and on a vertical plane."""
    builder = SceneBuilder("chip")
    builder.add(0.001 * (ROOF - ROOF.mean(axis=0)), BLACK)
    scene = Daylight(sky=sky, sky_illuminance=LEVEL, ground=0.0).scene(builder.build(), EFFICACY)
    for name, normal, share in (("horizontal", UP, 1.0), ("vertical", (0, -1, 0), {
            "uniform": 0.5, "cie-overcast": 3 * (np.pi / 2 + 4 / 3) / (7 * np.pi)}[sky])):
        yield Case(name=f"{sky} sky, {name} plane in the open, lux", truth=share * LEVEL,
                   found=_received(scene, [(0, 0, 1)], normal)[0])


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
        for place, truth, value in zip(places, truths, _received(scene, places), strict=True):
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
    for place, value in zip(places, _received(scene, places), strict=True):
        yield Case(name=f"luminaire 2 above, {place[0]:g} x {place[1]:g} aside, lux",
                   truth=1000 * 4 / (place @ place + 4) ** 2, found=value)


def _transmittance(angle):
    """Of a pane of index 1.5 by the angles of Snell's law."""
    if angle == 0:
        surface = 0.04
    else:
        refracted = np.arcsin(np.sin(angle) / 1.5)
        across = np.sin(angle - refracted) / np.sin(angle + refracted)
        parallel = np.tan(angle - refracted) / np.tan(angle + refracted)
        surface = (across**2 + parallel**2) / 2
    return (1 - surface) / (1 + surface)


def glazing() -> Iterator[Case]:
    """The share of sunlight that passes a pane by its angle, and that of a uniform sky."""
    builder = SceneBuilder("pane")
    pane = np.array([(-5.0, -5, 1), (5, -5, 1), (5, 5, 1), (-5, 5, 1)]) * (1e3, 1e3, 1)
    builder.add(pane, Material(name="glass", transparent=(1, 1, 1), thin=True), two_sided=True)
    for degrees in (0, 20, 40, 60, 70, 80):
        angle = np.radians(degrees)
        sun = DirectionalLight(direction=(0, np.sin(angle), -np.cos(angle)), irradiance=(100 / EFFICACY,) * 3)
        value = _received(builder.build(lights=(sun,)), [(0, 0, 0)], settings={"max_edge": 1e5})[0]
        yield Case(name=f"pane, sun at {degrees} degrees, transmittance in %", truth=100 * _transmittance(angle),
                   found=value / np.cos(angle))
    sky = Daylight(sky="uniform", sky_illuminance=100.0, ground=0.0).scene(builder.build(), EFFICACY)
    diffuse = quad(lambda angle: np.sin(2 * angle) * _transmittance(angle), 1e-9, np.pi / 2 - 1e-9)[0]
    yield Case(name="pane, uniform sky, transmittance in %", truth=100 * diffuse,
               found=_received(sky, [(0, 0, 0)], settings={"max_edge": 1e5})[0])


CASES: dict[str, Callable[[], Iterator[Case]]] = {
    **{f"{sky} sky": partial(open_sky, sky) for sky in ("uniform", "cie-overcast")},
    **{f"{opening}, {sky} sky": partial(sky_component, sky, opening) for opening in ("roof", "facade")
       for sky in SKIES},
    **{f"cube of {share:g}": partial(reflections, share) for share in (0.1, 0.5, 0.9)},
    "lamps": lamps, "luminaire": luminaire, "glazing": glazing}
"""By name what measures some cases."""
