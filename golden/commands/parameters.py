"""Types of options and arguments that several commands have."""

from pathlib import Path

import click
import numpy as np

from golden.config import PRESETS

__all__ = ["ASSIGNMENTS", "FILE", "PRESET", "SCENE_HELP", "Positive", "Triple", "WholePair"]

FILE = click.Path(path_type=Path)
PRESET = click.option("--preset", type=click.Choice(list(PRESETS)), default="paper", help="Of the parameters.")
ASSIGNMENTS = click.option("-P", "assignments", multiple=True, metavar="PATH=VALUE",
                           help="Another value of a parameter, for example icu.rays=4096. May be repeated.")
SCENE_HELP = "SCENE is a built-in name (see `scenes`), NAME:SIZE, or a file: .obj .ply .stl .gltf .glb .nff."


class WholePair(click.ParamType):
    """Two whole numbers ``AxB``."""

    def __init__(self, name: str):
        self.name = name

    def get_metavar(self, param, ctx):
        """What the help calls a value."""
        return self.name

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, tuple):
            return value
        parts = value.lower().split("x")
        if len(parts) != 2 or not all(part.isascii() and part.isdigit() and len(part) <= 9 for part in parts):
            self.fail(f"{value!r} is not two whole numbers like {self.name}", param, ctx)
        return tuple(int(part) for part in parts)


class Triple(click.ParamType):
    """Three finite numbers ``x,y,z`` of at least ``least``."""

    def __init__(self, name: str = "X,Y,Z", least: float = -np.inf):
        self.name, self._least = name, least

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, tuple):
            return value
        try:
            triple = tuple(float(part) for part in value.split(","))
        except ValueError:
            triple = ()
        if len(triple) != 3 or not np.all(np.isfinite(triple)) or min(triple) < self._least:
            limit = "" if self._least == -np.inf else f" of at least {self._least:g}"
            self.fail(f"{value!r} is not three finite numbers{limit} like {self.name}", param, ctx)
        return triple


class Positive(click.ParamType):
    """A finite number above 0."""

    name = "NUMBER"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        try:
            number = float(value)
        except ValueError:
            number = np.nan
        if not 0 < number < np.inf:
            self.fail(f"{value!r} is not a finite number above 0", param, ctx)
        return number
