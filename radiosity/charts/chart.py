"""Charts of lines, and of bars in lanes, as SVG: equal values give equal bytes."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from golden.base.output import check_outputs, whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["COLOURS", "Bars", "Line", "check_chart", "lane_figure", "line_figure", "new_figure", "write_figure"]

# Distinguished also by those who do not see all colours.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
# Whatever a user's matplotlibrc says; names of elements by content, and letters as text, not as outlines.
_STYLE = {"svg.hashsalt": "radiosity", "svg.fonttype": "none", "font.size": 9, "axes.titlelocation": "left",
          "axes.grid": True, "axes.axisbelow": True, "grid.color": "#dddddd", "legend.frameon": False}


@dataclass(frozen=True, kw_only=True)
class Line:
    """Points by ascending x; those that are not finite are left out. ``ends_at`` is marked on the x axis."""

    name: str
    x: np.ndarray
    y: np.ndarray
    ends_at: float | None = None


@dataclass(frozen=True, kw_only=True)
class Bars:
    """Bars of one colour in lanes.

    Parameters
    ----------
    lane, begin, end
        Of each bar its lane, from 0 on, and where it begins and ends.
    colour
        Of all bars.
    top, bottom
        What they take of a lane's height, 0 to 1 from its top.
    name
        In the legend; none if it is empty.
    """

    lane: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    colour: str
    top: float = 0.1
    bottom: float = 0.9
    name: str = ""


def check_chart(path: Path | None) -> None:
    """A chart can be drawn and written (None is skipped); to be checked before the work starts.

    Raises
    ------
    InputError
        The path does not end in .svg, or no file can be made there.
    ModuleNotFoundError
        matplotlib is not installed.
    """
    check_outputs(path, suffixes=(".svg",))
    if path is not None and find_spec("matplotlib") is None:
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib")


def line_figure(lines: list[Line], *, title: str, x_name: str, y_name: str, y_top: float) -> "Figure":
    """One chart; what is above ``y_top`` is cut off."""
    with new_figure(10, 6) as figure:
        axes = figure.subplots()
        for number, line in enumerate(lines):
            known, colour = np.isfinite(line.y), COLOURS[number % len(COLOURS)]
            axes.plot(line.x[known], line.y[known], color=colour, linewidth=2, label=line.name)
            if line.ends_at is not None:
                axes.plot(line.ends_at, 0, color=colour, marker="^", clip_on=False)
        axes.set(title=title, xlabel=x_name, ylabel=y_name, ylim=(0, y_top),
                 xlim=(0, max(float(np.max(line.x)) for line in lines) * 1.02))
        axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def lane_figure(lanes: list[str], bars: list[Bars], *, title: str, x_name: str) -> "Figure":
    """A lane for each name, from the top; a bar without a length is a stroke."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    with new_figure(12, 1 + 0.3 * len(lanes)) as figure:
        axes = figure.subplots()
        for one in bars:
            corners = np.stack([np.stack([x, one.lane + y], axis=-1) for x, y in (
                (one.begin, one.top), (one.end, one.top), (one.end, one.bottom), (one.begin, one.bottom))], axis=1)
            axes.add_patch(PathPatch(Outline.make_compound_path_from_polys(corners), color=one.colour, linewidth=0.2,
                                     label=one.name))
        drawn = [one for one in bars if len(one.lane)]
        axes.set(title=title, xlabel=x_name, ylim=(len(lanes), 0), xlim=(
            min((one.begin.min() for one in drawn), default=0), max((one.end.max() for one in drawn), default=1)),
                 yticks=np.arange(len(lanes)) + 0.5, yticklabels=lanes)
        axes.grid(visible=False, axis="y")
        if any(one.name for one in bars):
            axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


@contextmanager
def new_figure(width: float, height: float) -> Iterator["Figure"]:
    """An empty figure of so many inches to draw on in the style of all charts."""
    from matplotlib import style
    from matplotlib.figure import Figure

    with style.context(["default", _STYLE]):
        yield Figure(figsize=(width, height), layout="constrained")


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure, atomically; its folder is made."""
    from matplotlib import style

    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part, style.context(["default", _STYLE]):
        figure.savefig(part, format="svg", metadata={"Creator": None, "Date": None})
