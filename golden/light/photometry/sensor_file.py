"""Sensors from a text file."""

from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.light.photometry.sensors import Sensors
from golden.scene.file_text import lines_of, numbers
from golden.scene.parser import check_regular

__all__ = ["read_sensors"]

# Most points of a file.
MOST = 1_000_000


def read_sensors(path: Path) -> Sensors:
    """The sensors of a file, in its order.

    A line ``x y z nx ny nz`` is one sensor: a point and the direction that it faces, as the program Radiance has them.
    A line ``plane x y z  ux uy uz  vx vy vz  m n`` is a work plane: from the corner (x, y, z) its edges u and v are cut
    into m and n steps, with a sensor at the centre of each of the m x n fields, which faces u x v; u runs fastest.
    Empty lines and what follows ``#`` count for nothing.

    Raises
    ------
    InputError
        The file cannot be read, or a line is neither; one line of text with the path and the number of the line.
    """
    check_regular(path)
    try:
        lines = lines_of(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    position, normal, plane, planes, count = [], [], [], 0, 0
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            points, direction = _plane(words[1:]) if words[0] == "plane" else _point(words)
            count += len(points)
            if count > MOST:
                raise InputError(f"Sensors must be at most {MOST}, not {count}")
            Sensors(position=points[:1], normal=[direction])
        except InputError as error:
            raise InputError(f"{path}: line {number}: {str(error).removeprefix('sensors: ')}") from error
        position.append(points)
        normal.append(np.tile(direction, (len(points), 1)))
        plane.append(np.full(len(points), planes if words[0] == "plane" else -1))
        planes += words[0] == "plane"
    if not position:
        raise InputError(f"{path}: it has no sensors")
    return Sensors(position=np.concatenate(position), normal=np.concatenate(normal), plane=np.concatenate(plane))


def _numbers(words, form):
    try:
        values = np.array(numbers(words))
    except ValueError:
        values = np.zeros(0)
    if len(values) != len(form.split()):
        raise InputError(f"Values must be the numbers {form}, not {' '.join(words)!r}")
    return values


def _point(words):
    values = _numbers(words, "x y z nx ny nz")
    return values[None, :3], values[3:]


def _plane(words):
    values = _numbers(words, "x y z ux uy uz vx vy vz m n")
    corner, along, up = values[:9].reshape(3, 3)
    steps = values[9:]
    if not (np.isfinite(values).all() and (steps >= 1).all() and (steps == np.floor(steps)).all()):
        raise InputError(f"Steps of a plane must be whole numbers of at least 1, not {' '.join(words[9:])!r}")
    if steps.prod() > MOST:
        raise InputError(f"Sensors must be at most {MOST}, not {steps.prod():g}")
    return Sensors.on_plane(corner, along, up, tuple(steps.astype(int))).position, np.cross(along, up)
