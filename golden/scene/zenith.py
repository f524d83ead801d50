"""Lines for the user on a scene's up: which it is, where it is from, and what speaks against it."""

import re
from pathlib import Path

import numpy as np

from golden.base.input_warnings import warn
from golden.scene.load import UP
from golden.scene.scene import Scene

__all__ = ["named_direction", "warn_of_upright_floors", "zenith_line"]

_FORMATS = {".gltf": "glTF files have", ".nff": "the view of NFF files has"}

# Words in the names of materials of level surfaces.
_LEVEL = {"floor", "floors", "ceiling", "ceilings", "ceil", "ground", "boden", "fussboden", "decke", "vloer", "sol",
          "plancher", "plafond", "suelo", "techo", "pavimento", "soffitto"}

# Cosine of the normal with the up below which a surface counts as upright, that from which on it counts as level, and
# the least share of the area of all named surfaces that must agree.
_UPRIGHT, _FLAT, _MOST = 0.5, 0.9, 0.99


def zenith_line(spec: str, scene: Scene, *, is_given: bool, facing: np.ndarray | None = None) -> str:
    """The scene's up and where it is from, in a line.

    Parameters
    ----------
    spec, scene
        The scene by its name and opened (`golden.scene.open.open_scene`).
    is_given
        Whether the user gave the zenith.
    facing
        S x 3 unit vectors: where sensors face. If all face one axis that is level, the line names it.
    """
    suffix = Path(spec).suffix.lower()
    if is_given:
        origin = "as given"
    elif suffix in UP or suffix in _FORMATS:
        origin = f"as {_FORMATS.get(suffix, f'{suffix[1:].upper()} files have')} it (--zenith)"
    else:
        origin = "that of the scene (--zenith)"
    line = f"zenith {named_direction(scene.up)}, {origin}"
    common = None if facing is None or is_given else facing[0]
    if common is not None and np.allclose(facing, common) and abs(common @ scene.up) < 1e-6:
        line += f"; all sensors face {named_direction(common)}, which is level"
    return line


def warn_of_upright_floors(scene: Scene) -> None:
    """Warn if all patches whose materials are named after floors or ceilings stand upright, and lie along an axis."""
    is_named = [not _LEVEL.isdisjoint(re.split(r"[\W\d_]+", one.name.lower())) for one in scene.materials]
    chosen = np.array(is_named)[scene.material]
    area = scene.areas[chosen]
    if not area.sum():
        return
    cosine = np.abs(scene.normals[chosen])
    upright = np.abs(scene.normals[chosen] @ scene.up) < _UPRIGHT * np.linalg.norm(scene.up)
    level = area @ (cosine > _FLAT)
    axis = int(level.argmax())
    if area @ upright >= _MOST * area.sum() and level[axis] >= _MOST * area.sum():
        warn(f"scene {scene.name!r}: with the zenith {named_direction(scene.up)} all surfaces named like floors or "
             f"ceilings stand upright; they are level with --zenith {','.join(map(str, np.eye(3, dtype=int)[axis]))}")


def named_direction(direction) -> str:
    """A direction along an axis by its name, such as +y; any other one by its numbers."""
    direction = np.asarray(direction, dtype=np.float64)
    along = np.flatnonzero(direction)
    if len(along) == 1:
        return f"{'-' if direction[along[0]] < 0 else '+'}{'xyz'[along[0]]}"
    return ",".join(f"{value:g}" for value in direction)
