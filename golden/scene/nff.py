"""Reader of the Neutral File Format (NFF) after E. Haines' description of it.

``read_nff`` describes each entity.
"""

import math
import re
from dataclasses import dataclass, replace
from pathlib import PurePath

import numpy as np

from golden.base.errors import InputError
from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.file_text import is_number, lines_of
from golden.scene.file_text import number as number_of
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.polygons import cut_polygon
from golden.scene.scene import Scene
from golden.scene.tessellate import frustum, sphere
from golden.scene.unused import Unused

__all__ = ["read_nff"]

UNFILLED = Material(name="unfilled", diffuse=(0.7, 0.7, 0.7))
"""Material of objects before the first fill."""

NEAREST_LIGHT = 0.1
"""Least distance of a light from the middle of the scene, in diagonals of the scene box."""

LARGEST = 1e30
"""Largest magnitude of a value: areas and intensities of such coordinates are finite."""

MOST_ROUND = 1 << 22
"""Most patches of spheres, cones and cylinders, which take few bytes of a file each."""

VIEW = {"from": 3, "at": 3, "up": 3, "angle": 1, "hither": 1, "resolution": 2}
REQUIRED_VIEW = ("from", "at", "up", "angle")
COUNTS = {"v": (0,), "b": (3,), "l": (3, 6), "f": (8,), "s": (4,), "c": (8,)}
PER_VERTEX = {"p": 3, "pp": 6}
OBJECTS = ("s", "c", "p", "pp")


@dataclass(frozen=True)
class _Statement:
    """A keyword at the start of a line and all numbers up to the next one."""

    keyword: str
    where: str
    values: list[float]

    def error(self, what) -> InputError:
        return InputError(f"{self.where}: {what}")


def _statements(lines: list[str], name: str) -> list[_Statement]:
    statements = []
    for number, line in enumerate(lines, start=1):
        words = re.split(r"(?:^|\s)#", line, maxsplit=1)[0].split()
        if not words:
            continue
        where = f"{name}:{number}"
        if words[0] in COUNTS or words[0] in PER_VERTEX or words[0] in VIEW:
            statements.append(_Statement(words.pop(0), where, []))
        elif not statements or not is_number(words[0]):
            raise InputError(f"{where}: unknown entity {words[0]!r}")
        for word in words:
            if not is_number(word):
                raise InputError(f"{where}: {word!r} is not a number")
            value = number_of(word)
            if not math.isfinite(value):
                raise InputError(f"{where}: {word!r} is not a finite number")
            if abs(value) > LARGEST:
                raise InputError(f"{where}: {word!r} is beyond {LARGEST:g}")
            statements[-1].values.append(value)
    return statements


def _check_count(statement: _Statement) -> None:
    keyword, found = statement.keyword, len(statement.values)
    if keyword in PER_VERTEX:
        if not found or not statement.values[0].is_integer():
            raise InputError(f"{keyword!r} needs a whole number of vertices")
        vertices = int(statement.values[0])
        if vertices < 3:
            raise InputError(f"{keyword!r} needs at least 3 vertices, not {vertices}")
        expected, found = (PER_VERTEX[keyword] * vertices,), found - 1
        keyword = f"{keyword} {vertices}"
    else:
        expected = COUNTS.get(keyword) or (VIEW[keyword],)
    if found not in expected:
        raise InputError(f"{keyword!r} needs {' or '.join(map(str, expected))} values, not {found}")


class _Reader:
    """Reads statements one after the other into a scene builder, a camera and lights."""

    def __init__(self, name: str):
        self.builder = SceneBuilder(name)
        self.camera: Camera | None = None
        self.lights: list[tuple[list[float], list[float]]] = []
        self.background, self._has_background = (0.0, 0.0, 0.0), False
        self._material = UNFILLED
        self._fills: dict[tuple[float, ...], Material] = {}
        self._view: dict[str, list[float]] = {}
        self._view_start: _Statement | None = None
        self._curved: list[np.ndarray] = []
        self._round = 0
        self.unused = Unused()

    def take(self, statement: _Statement) -> None:
        """Reads one statement."""
        if statement.keyword not in VIEW:
            self._end_view()
        if statement.keyword != "pp":
            self._end_curved()
        try:
            _check_count(statement)
            getattr(self, f"_take_{statement.keyword}", self._take_view_part)(statement)
        except InputError as error:
            raise statement.error(error) from None

    def end(self) -> None:
        """Ends an open view and an open smooth surface."""
        self._end_view()
        self._end_curved()

    def _end_view(self) -> None:
        if self._view_start is None:
            return
        view, start, self._view_start = self._view, self._view_start, None
        missing = [part for part in REQUIRED_VIEW if part not in view]
        if missing:
            raise start.error(f"the view has no {missing[0]!r}")
        try:
            self.camera = Camera(eye=view["from"], target=view["at"], up=view["up"], fov=view["angle"][0])
        except InputError as error:
            raise start.error(error) from None

    def _end_curved(self) -> None:
        if self._curved:
            self.builder.add(np.concatenate(self._curved), self._material, smooth=True, two_sided=True)
            self._curved = []

    def _take_v(self, statement: _Statement) -> None:
        self.unused.add("view before the last one", self.camera is not None)
        self._view, self._view_start = {}, statement

    def _take_view_part(self, statement: _Statement) -> None:
        if self._view_start is None:
            raise InputError(f"{statement.keyword!r} is not within a view ('v')")
        if statement.keyword in self._view:
            raise InputError(f"the view has a second {statement.keyword!r}")
        self._view[statement.keyword] = statement.values

    def _take_b(self, statement: _Statement) -> None:
        if min(statement.values) < 0:
            raise InputError(f"the background must not be negative, not {tuple(statement.values)!r}")
        self.unused.add("background before the last one", self._has_background)
        self.background, self._has_background = tuple(statement.values), True

    def _take_l(self, statement: _Statement) -> None:
        position, color = statement.values[:3], statement.values[3:] or [1.0, 1.0, 1.0]
        if min(color) < 0:
            raise InputError(f"the light's colour must not be negative, not {tuple(color)!r}")
        self.lights.append((position, color))

    def _take_f(self, statement: _Statement) -> None:
        values = tuple(statement.values)
        if values not in self._fills:
            self._fills[values] = _fill(f"fill {len(self._fills) + 1}", values, self.unused)
        self._material = self._fills[values]

    def _take_s(self, statement: _Statement) -> None:
        *center, radius = statement.values
        self._add_round(sphere(center, radius))

    def _take_c(self, statement: _Statement) -> None:
        *base, base_radius = statement.values[:4]
        *apex, apex_radius = statement.values[4:]
        self._add_round(frustum(base, apex, base_radius, apex_radius))

    def _add_round(self, patches: np.ndarray) -> None:
        self._round += len(patches)
        if self._round > MOST_ROUND:
            raise InputError(f"its spheres, cones and cylinders have more than {MOST_ROUND} patches")
        self.builder.add(patches, self._material, smooth=True)

    def _take_p(self, statement: _Statement) -> None:
        patches = cut_polygon(np.array(statement.values[1:]).reshape(-1, 3))
        self.builder.add(patches, self._material, surface=0, two_sided=True)

    def _take_pp(self, statement: _Statement) -> None:
        self._curved.append(cut_polygon(np.array(statement.values[1:]).reshape(-1, 6)[:, :3]))


def _fill(name: str, values: tuple[float, ...], unused: Unused) -> Material:
    color, (kd, ks, _, transmittance, index) = np.array(values[:3]), values[3:]
    if min(*values[:5], transmittance) < 0:
        raise InputError("colour, Kd, Ks and T of a fill must not be negative")
    shares = np.array((kd * color, ks * np.ones(3), transmittance * color))
    unused.add("shares beyond a sum of 1", shares.sum(axis=0).max() > 1 + 1e-9)
    shares /= max(1.0, shares.sum(axis=0).max())
    diffuse, specular, transparent = (tuple(share) for share in shares.tolist())
    return Material(name=name, diffuse=diffuse, specular=specular, transparent=transparent,
                    refraction_index=index if transmittance > 0 else 1.0)


def _point_lights(lights, bounds: np.ndarray) -> tuple[PointLight, ...]:
    least = NEAREST_LIGHT * np.linalg.norm(bounds[1] - bounds[0])
    placed = []
    for position, color in lights:
        distance = max(np.linalg.norm(bounds.mean(axis=0) - position), least)
        intensity = np.pi * distance**2 / np.sqrt(len(lights)) * np.array(color)
        placed.append(PointLight(position=tuple(position), intensity=tuple(intensity.tolist())))
    return tuple(placed)


def read_nff(data: bytes, name: str) -> Scene:
    """Reads a scene in NFF.

    * ``v``: the camera. ``angle`` is the full vertical field of view; ``hither`` and ``resolution`` are not used.
    * ``b``: the background radiance.
    * ``l``: a point light. The format has no falloff; a light of colour C among n lights gets the intensity with which
      the irradiance in the middle of the scene box is pi C / sqrt(n), so that a white surface there has radiance
      C / sqrt(n).
    * ``f``: the material of what follows: diffuse Kd times the colour, specular Ks, transparent T times the colour, all
      scaled down together if a channel's sum is over 1. Phong's exponent has no counterpart, the index of refraction
      none where T is 0. Objects before the first ``f`` are a light grey.
    * ``s``, ``c``: smooth, one-sided surfaces, the front outside. Cones and cylinders are open as the format has it.
    * ``p``, ``pp``: two-sided, as writers do not agree about the orientation; ``pp`` that follow one another are one
      smooth surface. Their normals are not used.

    Parameters
    ----------
    data
        The file's content.
    name
        The file's name, for messages; its stem is the scene's name.

    Raises
    ------
    InputError
        ``NAME:LINE: ...``: an unknown entity, a wrong number of values, a value that is no finite number or that the
        entity cannot have, or a file without any object.

    Warns
    -----
    InputWarning
        Names further views and backgrounds, and shares that were scaled down.
    """
    reader = _Reader(PurePath(name).stem)
    statements = _statements(lines_of(data), name)
    if not any(statement.keyword in OBJECTS for statement in statements):
        raise InputError(f"{name}: it has no object ({', '.join(OBJECTS)})")
    for statement in statements:
        reader.take(statement)
    reader.end()
    reader.unused.warn()
    view = {} if reader.camera is None else {"camera": reader.camera, "up": tuple(reader.camera.up)}
    scene = reader.builder.build(**view, background=reader.background)
    return replace(scene, lights=_point_lights(reader.lights, scene.bounds))
