"""A scene by name."""

from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.builtin import BUILTIN, builtin_scene
from golden.scene.load import SUFFIXES, load_scene
from golden.scene.scene import Scene

__all__ = ["open_scene"]


def open_scene(spec: str, *, zenith=None, facets: bool = False) -> Scene:
    """The built-in scene ``NAME`` or ``NAME:SIZE``, or else the scene of a file.

    Parameters
    ----------
    zenith
        The scene's up, three numbers. Default: that of the built-in scene, or of the file's format (`UP`).
    facets
        See `load_scene`.

    Raises
    ------
    InputError
        Neither a built-in scene nor a file has that name, it cannot be made, or the zenith is no direction.
    """
    if zenith is None:
        return _opened(str(spec), facets)
    if np.shape(zenith) != (3,) or not np.isfinite(zenith).all() or not np.any(zenith):
        raise InputError(f"scene: Zenith must be three finite values, not all zero, not {zenith!r}", parameter="zenith")
    return replace(_opened(str(spec), facets), up=tuple(map(float, zenith)))


def _opened(spec, facets):
    if spec.partition(":")[0] in BUILTIN:
        return builtin_scene(spec)
    path = Path(spec)
    if spec and (path.suffix.lower() in SUFFIXES or path.exists()):
        return load_scene(path, facets=facets)
    meant = get_close_matches(spec.partition(":")[0].lower(), BUILTIN, n=1)
    hint = f"did you mean {meant[0]!r}? Built in are" if meant else "built in are"
    raise InputError(f"scene {spec!r}: no built-in scene and no file has that name; {hint} {', '.join(BUILTIN)}")
