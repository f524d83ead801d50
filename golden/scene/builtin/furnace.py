"""A closed cube whose light is known in closed form."""

import numpy as np

from golden.base.errors import InputError, check_choice
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import FACES, box
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["furnace"]


def furnace(size: int = 8, *, diffuse: float = 0.5, emission: float = 1.0, emitter: str | None = None) -> Scene:
    """The unit cube seen from inside, ``size`` x ``size`` patches a face; neighbours share their vertices, edges too.

    Parameters
    ----------
    size
        Patches along an edge.
    diffuse
        Reflectance of every face, but of a black emitter.
    emission
        Radiance that every face sends out by itself: then all of them shine with ``emission / (1 - diffuse)``.
    emitter
        The one face that emits, which is then black: one of ``"-x"`` to ``"+z"`` (``"+z"`` is the ceiling).

    Raises
    ------
    InputError
        An argument is out of range.
    """
    if size < 1:
        raise InputError(f"furnace: Size must be at least 1, not {size!r}")
    if emitter is not None:
        check_choice("furnace: Emitter", emitter, FACES)
    wall = Material(name="wall", diffuse=(diffuse,) * 3, emission=(emission if emitter is None else 0.0,) * 3)
    light = Material(name="emitter", emission=(emission,) * 3)
    builder = SceneBuilder("furnace")
    for face, quad in zip(FACES, box((0, 0, 0), (1, 1, 1)), strict=True):
        builder.add(_grid(quad[::-1], size), light if face == emitter else wall, surface=np.zeros(size * size))
    return builder.build(camera=Camera(eye=(0.1, 0.2, 0.5), target=(0.9, 0.7, 0.45), fov=70.0))


def _grid(quad: np.ndarray, size: int) -> np.ndarray:
    """A unit square cut into ``size`` x ``size``. Coordinates are k / size on every face alike."""
    step = np.arange(size + 1)
    right, up = quad[1] - quad[0], quad[3] - quad[0]
    points = (quad[0] * size + step[:, None, None] * right + step[:, None] * up) / size
    return np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(-1, 4, 3)
