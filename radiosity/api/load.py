"""Scenes by name."""

import os

from golden.scene.open import open_scene
from golden.scene.scene import Scene

__all__ = ["load"]


def load(scene: str | os.PathLike[str], *, zenith: tuple[float, float, float] | None = None,
         facets: bool = False) -> Scene:
    """The scene of a file (OBJ, PLY, STL, glTF, GLB, NFF, VS3), or a built-in one.

    Parameters
    ----------
    scene
        A path, or the name of a built-in scene such as ``"cornell"`` or ``"furnace:4"``.
    zenith
        The scene's up. Default: that of the format.
    facets
        Whether each face of a file is one patch, in the file's order, whose front alone radiates.

    Raises
    ------
    InputError
        There is no such scene, or its file cannot be used.
    """
    return open_scene(os.fspath(scene), zenith=zenith, facets=facets)
