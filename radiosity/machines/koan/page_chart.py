"""A chart of who holds which page of a shared memory over time."""

from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from radiosity.charts.chart import COLOURS, new_figure, write_figure
from radiosity.machines.koan.koan_run import KoanRun
from radiosity.machines.koan.page_state import READ, WRITE

__all__ = ["LOG_ROWS", "holders", "write_page_chart"]

LOG_ROWS = 1 << 20
"""Changes that a run of a chart logs at most."""

_STEPS, _COLUMNS = 6, 3
_FREE, _BLANK = (0.93, 0.93, 0.93), (1.0, 1.0, 1.0)


def holders(log: np.ndarray, nodes: int, pages: int, times: np.ndarray) -> np.ndarray:
    """Which nodes hold each page at each time.

    Parameters
    ----------
    log
        L x 4: time, node, page, and mode or loss, see `PageState`.
    nodes, pages
        N and P.
    times
        K ascending.

    Returns
    -------
    K x P x N bool.
    """
    held = np.zeros((len(times), pages, nodes), dtype=bool)
    held[:, np.arange(pages), np.arange(pages) % nodes] = True
    for time, node, page, code in log:
        held[times >= time, page, node] = code in (READ, WRITE)
    return held


def write_page_chart(path: Path, run: KoanRun, *, title: str) -> None:
    """Write six steps of a run as an SVG.

    A step has a square for each page, row by row: grey where the home alone holds it, and the darker blue the more
    nodes do.

    Raises
    ------
    InputError
        The run has more changes than it has logged.
    """
    changes = int(run.state.logged[0])
    if changes > len(run.state.log):
        raise InputError(f"koan: Changes of pages must be at most {len(run.state.log)} for a chart, not {changes}")
    pages, nodes = len(run.layout), run.nodes
    # Pages spread fast at first.
    times = np.rint(run.time * np.linspace(0, 1, _STEPS) ** 2).astype(np.int64)
    held = holders(run.state.log[:changes], nodes, pages, times)
    side = int(np.ceil(np.sqrt(pages)))
    full = np.array([int(COLOURS[0][at:at + 2], 16) / 255 for at in (1, 3, 5)])
    with new_figure(9, 7) as figure:
        panels = figure.subplots(_STEPS // _COLUMNS, _COLUMNS)
        for axes, time, holding in zip(panels.flat, times, held, strict=True):
            copies = holding.sum(axis=1)
            share = 0.15 + 0.85 * (copies[:, None] - 1) / max(1, nodes - 1)
            squares = np.full((side * side, 3), _BLANK)
            squares[:pages] = np.where(copies[:, None] <= 1, _FREE, 1 - share * (1 - full))
            axes.imshow(squares.reshape(side, side, 3), interpolation="none")
            axes.set_axis_off()
            axes.set_title(f"{time / 1e9:.2f} s, {copies.sum() - pages:,} copies")
        figure.suptitle(title)
        figure.supxlabel("a square is a page: grey at its home alone, darker blue in more caches")
    write_figure(path, figure)
