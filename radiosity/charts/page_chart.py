"""A chart of who holds which page of a shared memory over time."""

from html import escape
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import whole_file
from radiosity.charts.chart import COLOURS
from radiosity.machines.koan.koan_run import KoanRun
from radiosity.machines.koan.page_state import READ, WRITE

__all__ = ["LOG_ROWS", "holders", "write_page_chart"]

LOG_ROWS = 1 << 20
"""Changes that a run of a chart logs at most."""

_STEPS, _COLUMNS, _CELL, _PANEL, _TOP, _GAP = 6, 3, 5, 48, 40, 26
_FREE = "#eeeeee"


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
    changes = int(run.state.times[-1])
    if changes > len(run.state.log):
        raise InputError(f"koan: Changes of pages must be at most {len(run.state.log)} for a chart, not {changes}")
    pages, nodes = len(run.layout), run.nodes
    # Pages spread fast at first.
    times = np.rint(run.time * np.linspace(0, 1, _STEPS) ** 2).astype(np.int64)
    held = holders(run.state.log[:changes], nodes, pages, times)
    side = int(np.ceil(np.sqrt(pages)))
    panel = side * _CELL
    width, height = _COLUMNS * (panel + _GAP) + _GAP, _TOP + -(-_STEPS // _COLUMNS) * (panel + _PANEL) + _GAP
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
             f'font-size="11"><rect width="{width}" height="{height}" fill="white"/>',
             f'<text x="{_GAP}" y="22" font-size="14">{escape(title)}</text>']
    for step, time in enumerate(times):
        left, top = _GAP + step % _COLUMNS * (panel + _GAP), _TOP + step // _COLUMNS * (panel + _PANEL) + 14
        copies = held[step].sum(axis=1)
        parts.append(f'<text x="{left}" y="{top - 4}">{time / 1e9:.2f} s, {copies.sum() - pages:,} copies</text>')
        for page, count in enumerate(copies):
            share = (count - 1) / max(1, nodes - 1)
            fill = _FREE if count <= 1 else COLOURS[0]
            parts.append(f'<rect x="{left + page % side * _CELL}" y="{top + page // side * _CELL}" '
                         f'width="{_CELL - 1}" height="{_CELL - 1}" fill="{fill}"'
                         + (f' fill-opacity="{0.15 + 0.85 * share:.2f}"' if count > 1 else "") + "/>")
    y = height - 10
    parts += [f'<text x="{_GAP}" y="{y}">a square is a page: grey at its home alone, darker blue in more caches</text>']
    with whole_file(path) as part:
        part.write_text("\n".join([*parts, "</svg>", ""]))
