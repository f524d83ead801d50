"""Types of options and arguments that several commands have."""

import math
from collections.abc import Callable
from pathlib import Path

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from radiosity.cli.console import console
from radiosity.cli.golden.choices import PRESETS, SCENE_SUFFIXES

__all__ = ["ASSIGNMENTS", "AZIMUTHS", "CELL", "FILE", "LEAST_RAYS", "METHOD_CELL", "PRESET", "SCENE", "SCENE_HELP",
           "ZENITH", "CellSize", "FiniteRange", "Numbers", "Place", "Positive", "WholePair", "is_given", "rays_option"]

FILE = click.Path(path_type=Path)
PRESET = click.option("--preset", type=click.Choice(PRESETS), default="paper", help="Choose the machine's parameters.")
ASSIGNMENTS = click.option("-P", "assignments", multiple=True, metavar="PATH=VALUE",
                           help="Set one of the machine's parameters, for example icu.rays=4096. May be repeated.")
SCENE_HELP = (f"SCENE is a built-in name (see `scenes`), NAME:SIZE, or a file: {' '.join(SCENE_SUFFIXES)}.")


class _SceneName(click.ParamType):
    """The name of a scene; the shell completes built-in names and files."""

    name = "SCENE"

    def shell_complete(self, ctx, param, incomplete):
        """Names that begin with what the user typed, and files."""
        from golden.scene.builtin import BUILTIN

        return [*(CompletionItem(name, help=BUILTIN[name].about) for name in BUILTIN if name.startswith(incomplete)),
                CompletionItem(incomplete, type="file")]


def SCENE(function):  # noqa: N802 - a decorator beside those of other parameters
    """The argument of a scene, and the option that refuses scenes which are not used as a whole."""
    def remember(ctx, param, value):
        console().strict = value

    strict = click.option("--strict", is_flag=True, expose_value=False, callback=remember,
                          help="Fail where the scene holds something that is not used, instead of a warning.")
    return click.argument("scene", type=_SceneName())(strict(function))


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


AZIMUTHS = WholePair("AZIMUTHSxPOLARS")


def rays_option(default: str = "256x64") -> Callable:
    """The option ``--rays`` of hemispheres."""
    return click.option("--rays", type=AZIMUTHS, default=default, help="Set the number of rays of each hemisphere.")


def is_given(name: str) -> bool:
    """Whether the user typed an option of the command that runs, by the name of its parameter."""
    return click.get_current_context().get_parameter_source(name) not in (ParameterSource.DEFAULT, None)


_COUNTS = {2: "two", 3: "three", 4: "four"}


class Numbers(click.ParamType):
    """Finite numbers of at least ``least``, as many as ``name`` has names: three, ``x,y,z``, or two."""

    def __init__(self, name: str = "X,Y,Z", least: float = -math.inf):
        self.name, self._least = name, least

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(float(part) for part in value.split(","))
        except ValueError:
            numbers = ()
        count = self.name.count(",") + 1
        if len(numbers) != count or not all(map(math.isfinite, numbers)) or min(numbers) < self._least:
            limit = "" if self._least == -math.inf else f" of at least {self._least:g}"
            self.fail(f"{value!r} is not {_COUNTS[count]} finite numbers{limit} like {self.name}", param, ctx)
        return numbers


ZENITH = click.option("--zenith", type=Numbers(), help="Set the direction that is up in the scene, for sky, sun, "
                      "luminaires, exported files and the default view.  [default: the format's]")


class Place(Numbers):
    """A point, and an angle in degrees that may be left out: four numbers."""

    def __init__(self):
        super().__init__("X,Y,Z,TURN")

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, str) and value.count(",") == 2:
            return (*Numbers().convert(value, param, ctx), 0.0)
        return super().convert(value, param, ctx)


class FiniteRange(click.FloatRange):
    """A finite number of a range: click's accepts nan in each, and infinity where a bound is missing."""

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number", param, ctx)
        return number


class Positive(click.ParamType):
    """A finite number above 0."""

    name = "NUMBER"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not 0 < number < math.inf:
            self.fail(f"{value!r} is not a finite number above 0", param, ctx)
        return number


CELL = click.option("--cell", type=Positive(), default=0.0625,
                    help="Set the cell size as a share of the scene's longest side.")


class CellSize(Positive):
    """A finite number above 0, or ``auto``: None."""

    name = "NUMBER|auto"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        return None if value in (None, "auto") else super().convert(value, param, ctx)


LEAST_RAYS = click.option("--least-rays", type=int, help="Cast the cells around a patch that fewer rays of a "
                          "hemisphere meet again, finer, until so many do or a grid has 4096 a side. Not with methods "
                          "of single rays.")
METHOD_CELL = click.option("--cell", type=CellSize(), default="auto", help="Set the size of the method's cells as a "
                           "share of the scene's longest side; auto is the method's choice.")
