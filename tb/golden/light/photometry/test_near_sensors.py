"""Light at sensors close to walls, furniture and windows, against sums over their hemispheres."""

import numpy as np
import pytest

from golden.light.photometry.sensors import Sensors
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

DISTANCES = np.array([0.01, 0.02, 0.05, 0.1, 0.5])
CAMERA = Camera(eye=(2, 3, 1), target=(2, 0, 1))
GREY, LIGHT = 0.6, np.array((0.9, 0.9, 2.1))
FLOOR = rectangle((0, 0, 0), (4, 0, 0), (0, 4, 0))
# Each receives light of the lamp, and reflects it to sensors at the distances from a point along a normal.
WALL = rectangle((0, 0, 0), (0, 0, 2.8), (4, 0, 0))
BODY = box((1.5, 0.4, 0), (3.1, 1.3, 0.75), omit=("-z",))
# Of 2 x 1.4 in a wall of 4 x 2.8.
OPENING = rectangle((1, 0, 0.9), (0, 0, 1.4), (2, 0, 0))
SCREEN = rectangle((1.3, 0.6, 0.2), (0.7, 0, 0), (0, 0, 1.9))


def mean_of_hemisphere(position, normal, radiance, across=300):
    """Irradiance over pi: the mean radiance of directions that are evenly spaced by the cosine."""
    share = (np.arange(across) + 0.5) / across
    radius, angle = np.sqrt(share)[:, None], 2 * np.pi * share
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2) + 0 * angle], axis=2)
    side = np.cross(normal, (1, 0, 0) if abs(normal[0]) < 0.5 else (0, 1, 0))
    side = side / np.linalg.norm(side)
    return radiance(position, local.reshape(-1, 3) @ np.array([side, np.cross(normal, side), normal])).mean()


def met(origin, direction, quad):
    """How far along directions a rectangle is, or infinity; and the points there."""
    along, up = quad[1] - quad[0], quad[3] - quad[0]
    normal = np.cross(along, up)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = ((quad[0] - origin) @ normal) / (direction @ normal)
        place = origin + distance[:, None] * direction
    u, v = ((place - quad[0]) @ edge / (edge @ edge) for edge in (along, up))
    inside = (distance > 0) & (u > 0) & (u < 1) & (v > 0) & (v < 1)
    return np.where(inside, distance, np.inf), place


def reflected(faces, screens=()):
    """A function from an origin and directions to the radiance of faces that the lamp lights past screens."""

    def radiance(origin, direction):
        nearest, light = np.full(len(direction), np.inf), np.zeros(len(direction))
        for quad in faces:
            distance, place = met(origin, direction, quad)
            normal = np.cross(quad[1] - quad[0], quad[3] - quad[0])
            normal /= np.linalg.norm(normal)
            toward = LIGHT - place
            cosine = np.maximum(toward @ normal, 0)
            bright = GREY / np.pi * cosine / (toward**2).sum(axis=1) ** 1.5
            bright[direction @ normal > 0] = 0
            for screen in screens:
                first, second = screen[1] - screen[0], screen[3] - screen[0]
                across = np.cross(first, second)
                share = ((screen[0] - place) @ across) / (toward @ across)
                at = place + share[:, None] * toward - screen[0]
                u, v = (at @ edge / (edge @ edge) for edge in (first, second))
                bright[(share > 0) & (share < 1) & (u > 0) & (u < 1) & (v > 0) & (v < 1)] = 0
            light = np.where(distance < nearest, bright, light)
            nearest = np.minimum(distance, nearest)
        for screen in screens:
            light[met(origin, direction, screen)[0] < nearest] = 0
        return light

    return radiance


def through_opening(origin, direction):
    return np.isfinite(met(origin, direction, OPENING)[0]).astype(float)


WHITE = Material(name="white", diffuse=(GREY,) * 3)
# What mirrors throw of a lamp without an area counts as diffuse.
HALF_MIRROR, MIRROR = (Material(name="mirror", specular=(share,) * 3, diffuse=(GREY - share,) * 3)
                       for share in (0.5, GREY))
LAMP = (PointLight(position=tuple(LIGHT), intensity=(1, 1, 1)),)
FRAME = np.array([rectangle((x, 0, z), (0, 0, height), (width, 0, 0)) for x, z, width, height in (
    (0, 0, 1, 2.8), (3, 0, 1, 2.8), (1, 0, 2, 0.9), (1, 2.3, 2, 0.5))])
# The patches and lights, the radiance that sensors see, a point of the surface, and the direction away from it.
CASES = {
    "wall": (((WALL, WHITE),), reflected([WALL]), (1.6, 0, 1.2), (0, 1, 0)),
    "edge of a shadow on a wall": (((WALL, WHITE), (SCREEN, BLACK, {"two_sided": True})), reflected([WALL], [SCREEN]),
                                   (2.1, 0, 1.2), (0, 1, 0)),
    "mirror": (((WALL, HALF_MIRROR),), reflected([WALL]), (1.6, 0, 1.2), (0, 1, 0)),
    "edge of a shadow on a mirror": (((WALL, MIRROR), (SCREEN, BLACK, {"two_sided": True})),
                                     reflected([WALL], [SCREEN]), (2.1, 0, 1.2), (0, 1, 0)),
    "furniture": (((BODY, WHITE),), reflected(BODY), (1.5, 0.9, 0.4), (-1, 0, 0)),
    "table": (((BODY, WHITE),), reflected(BODY), (1.7, 0.8, 0.75), (0, 0, 1)),
    "window": (((FRAME, BLACK), (box((0, 0, 0), (4, 4, 2.8), omit=("-y",))[:, ::-1], BLACK)), through_opening,
               (1.6, 0, 1.2), (0, 1, 0)),
}


@pytest.mark.parametrize(("name", "elements", "turned"), [
    *((name, 600, False) for name in ("wall", "mirror", "furniture", "window")),
    *(pytest.param(name, 3000, turned, marks=pytest.mark.nightly) for name in CASES for turned in (False, True))])
def test_sensors_close_to_a_surface_measure_the_sum_over_their_hemispheres(name, elements, turned):
    """Towards the surface, and turned along it, away from the lamp."""
    parts, radiance, start, away = CASES[name]
    lights = {"background": (1, 1, 1)} if name == "window" else {"lights": LAMP}
    scene = scene_of((FLOOR, BLACK), *parts, **lights)
    position = np.array(start) + DISTANCES[:, None] * np.array(away)
    normal = np.array(((1, 0, 0) if away[2] else (0, 0, -1)) if turned else away) * (1.0 if turned else -1.0)
    truth = [mean_of_hemisphere(place, normal, radiance) for place in position]
    found = render(scene, camera=CAMERA, settings=RenderSettings(
        width=2, height=2, samples=1, elements=elements, rays=(32, 16)),
        sensors=Sensors(position=position, normal=np.tile(normal, (len(position), 1)))).sensors[:, 1]
    np.testing.assert_allclose(found, truth, rtol=0.01)
