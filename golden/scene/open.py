"""A scene by name."""

from difflib import get_close_matches
from pathlib import Path

from golden.errors import InputError
from golden.scene.builtin import BUILTIN, builtin_scene
from golden.scene.load import SUFFIXES, load_scene
from golden.scene.scene import Scene

__all__ = ["open_scene"]


def open_scene(spec: str, *, up=None, facets: bool = False) -> Scene:
    """The built-in scene ``NAME`` or ``NAME:SIZE``, or else the scene of a file.

    Parameters
    ----------
    up, facets
        See `load_scene`; built-in scenes have their own.

    Raises
    ------
    InputError
        Neither a built-in scene nor a file has that name, or it cannot be made.
    """
    spec = str(spec)
    if spec.partition(":")[0] in BUILTIN:
        return builtin_scene(spec)
    path = Path(spec)
    if spec and (path.suffix.lower() in SUFFIXES or path.exists()):
        return load_scene(path, up=up, facets=facets)
    meant = get_close_matches(spec.partition(":")[0].lower(), BUILTIN, n=1)
    hint = f"did you mean {meant[0]!r}? Built in are" if meant else "built in are"
    raise InputError(f"scene {spec!r}: no built-in scene and no file has that name; {hint} {', '.join(BUILTIN)}")
