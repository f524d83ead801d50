"""The black room in which windows are measured, and what the truth of a window is."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from golden.light.photometry.quantities import lux
from golden.light.photometry.sensors import Sensors
from golden.render.two_pass import RenderSettings, render
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import FACES, box
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.sky.daylight import Daylight
from golden.scene.sky.distributions import Distribution, cie_clear, cie_overcast, horizontal, uniform

__all__ = ["BLACK", "EFFICACY", "GLASS", "LEVEL", "OPENINGS", "PLACES", "SKIES", "UP", "VIEW", "Case", "at", "daylit",
           "luminance", "received", "room", "through", "transmittance"]

UP = (0.0, 0.0, 1.0)
BLACK = Material(name="black")
GLASS = Material(name="glass", transparent=(1, 1, 1), thin=True)
# A room of 4 x 6 x 3, and its openings: in the middle of the roof, and in the wall to the south.
ROOM = np.array((4.0, 6.0, 3.0))
OPENINGS = {"roof": np.array([(1.5, 2.0, 3), (1.5, 4, 3), (2.5, 4, 3), (2.5, 2, 3)]),
            "facade": np.array([(1.0, 0, 1), (1, 0, 2.5), (3, 0, 2.5), (3, 0, 1)])}
PLACES = np.array([(2.0, 3, 0), (1, 1.5, 0), (0.5, 3.5, 0), (3.5, 5.5, 0)])
LEVEL, SUN, EFFICACY = 10_000.0, (200.0, 40.0), 179.0
SKIES: dict[str, Callable[[], Distribution]] = {"uniform": uniform, "cie-overcast": cie_overcast,
                                                "cie-clear": cie_clear}
VIEW = Camera(eye=(1, 1, 1.5), target=(2, 3, 0), up=UP)
POINTS = 96


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


def at(place) -> str:
    """A place on the floor in the name of a case."""
    return f"at ({place[0]:g}, {place[1]:g})"


def received(scene: Scene, places, normal=UP, *, settings: dict | None = None) -> np.ndarray:
    """Lux at places that face one way."""
    settings = {"width": 1, "height": 1, "samples": 1, "light_samples": 32, "rays": (64, 16), "max_edge": 9.0} | (
        settings or {})
    places = np.asarray(places, dtype=np.float64)
    result = render(scene, camera=VIEW, settings=RenderSettings(**settings),
                    sensors=Sensors(position=places, normal=np.tile(normal, (len(places), 1))))
    return lux(result.sensors, EFFICACY)


def room(opening: str, *more: tuple[np.ndarray, Material]) -> Scene:
    """A black room with one of `OPENINGS`, and patches with their materials beside it."""
    builder = SceneBuilder("room")
    face = {"roof": "+z", "facade": "-y"}[opening]
    for name, patch in zip(FACES, box((0, 0, 0), ROOM)[:, ::-1], strict=True):
        if name != face:
            builder.add(patch, BLACK, two_sided=True)
            continue
        hole = OPENINGS[opening]
        outer = patch[np.argmin(np.linalg.norm(patch[:, None] - hole[None], axis=2), axis=0)]
        builder.add(_frame(hole, outer), BLACK, two_sided=True)
    for patches, material in more:
        builder.add(patches, material, two_sided=material.thin)
    return builder.build()


def daylit(scene: Scene, sky: str) -> Scene:
    """The scene under one of `SKIES` without its sun, and above a black ground."""
    return Daylight(sky=sky, sun=SUN, sky_illuminance=LEVEL, sun_illuminance=0.0, ground=0.0).scene(scene, EFFICACY)


def luminance(sky: str) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Luminance of a sky, lm/(m2 sr), by K x 3 points, which do not matter, and K x 3 unit directions."""
    distribution = SKIES[sky]()
    azimuth, elevation = np.radians(SUN)
    sun = np.array((np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)))
    scale = LEVEL / horizontal(distribution, np.arccos(sun[2]))

    def shine(points, direction):
        sine = direction[:, 2]
        relative = distribution(np.maximum(sine, 0), np.arccos(np.clip(direction @ sun, -1, 1)))
        return np.where(sine > 0, scale * relative, 0.0)

    return shine


def through(opening, place, shine, normal=UP, *, points: int = POINTS) -> float:
    """Illuminance at a place through a rectangle, by quadrature.

    Parameters
    ----------
    opening
        4 x 3 corners.
    place, normal
        The place and the direction that it faces.
    shine
        What shines, as `luminance` returns it, by points of the rectangle.
    points
        Points of the quadrature along each side.
    """
    knots, weights = np.polynomial.legendre.leggauss(points)
    u, v = (grid.ravel() for grid in np.meshgrid((knots + 1) / 2, (knots + 1) / 2))
    along, across = opening[1] - opening[0], opening[3] - opening[0]
    met = opening[0] + u[:, None] * along + v[:, None] * across
    toward = met - place
    distance = np.linalg.norm(toward, axis=1)
    direction = toward / distance[:, None]
    density = shine(met, direction) * np.maximum(direction @ normal, 0) * np.abs(
        direction @ np.cross(along, across)) / distance**2
    return float(np.outer(weights, weights).ravel() @ density / 4)


def transmittance(cosine) -> np.ndarray:
    """Of a pane of index 1.5 by the cosine of incidence, from the angles of Snell's law."""
    angle = np.maximum(np.arccos(np.clip(cosine, 0, 1)), 1e-7)
    refracted = np.arcsin(np.sin(angle) / 1.5)
    across = np.sin(angle - refracted) / np.sin(angle + refracted)
    parallel = np.tan(angle - refracted) / np.tan(angle + refracted)
    surface = (across**2 + parallel**2) / 2
    return (1 - surface) / (1 + surface)


def _frame(opening, outer):
    """The four trapezoids between a rectangle and one around it, both from the same corner on."""
    return np.array([[outer[k], outer[k - 3], opening[k - 3], opening[k]] for k in range(4)])
