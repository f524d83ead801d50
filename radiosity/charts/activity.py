"""A chart of the activity of each cluster during a job."""

from html import escape
from pathlib import Path

import numpy as np

from radiosity.charts.chart import COLOURS, ticks

__all__ = ["write_activity"]

WIDTH, LEFT, RIGHT, TOP, BOTTOM, LANE, GAP = 900, 70, 110, 40, 44, 20, 6
# A cluster's sections alternate between two shades, so that their borders are seen.
_LOAD, _CAST, _RESULTS = COLOURS[4], (COLOURS[0], COLOURS[5]), COLOURS[2]


def write_activity(path: Path, *, clusters: int, loads: np.ndarray, casts: np.ndarray, title: str) -> None:
    """Write the chart: a lane for each cluster, and one for loads.

    Parameters
    ----------
    path
        The file (.svg).
    clusters
        Lanes.
    loads
        L x 2, begin and end of each load in cycles.
    casts
        S x 4: cluster, begin and end of the cast, and end of the writing of its results.
    title
        The title.
    """
    last = max([int(loads[:, 1].max(initial=1)), int(casts[:, 3].max(initial=1))])
    height = TOP + (clusters + 1) * (LANE + GAP) + BOTTOM
    right, bottom = WIDTH - RIGHT, height - BOTTOM

    def bar(lane, begin, end, colour, top=0.0, tall=LANE):
        x, y = LEFT + begin / last * (right - LEFT), TOP + lane * (LANE + GAP) + top
        return (f'<rect x="{x:.2f}" y="{y:.1f}" width="{max(0.3, (end - begin) / last * (right - LEFT)):.2f}" '
                f'height="{tall:.1f}" fill="{colour}"/>')

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" '
             'font-size="12">', f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
             f'<text x="{LEFT}" y="24" font-size="15">{escape(title)}</text>',
             f'<text x="{(LEFT + right) / 2}" y="{height - 8}" text-anchor="middle">cycle</text>']
    for tick in ticks(last):
        x = LEFT + tick / last * (right - LEFT)
        parts += [f'<path d="M{x:.1f} {TOP}V{bottom}" stroke="#ddd"/>',
                  f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{tick:,.0f}</text>']
    for lane, name in enumerate(("loads", *(f"cluster {number}" for number in range(clusters)))):
        parts.append(f'<text x="{LEFT - 8}" y="{TOP + lane * (LANE + GAP) + LANE - 5}" text-anchor="end">{name}</text>')
    parts += [bar(0, begin, end, _LOAD) for begin, end in loads]
    for cluster in range(clusters):
        own = casts[casts[:, 0] == cluster]
        for number, (_, begin, end, written) in enumerate(own[np.argsort(own[:, 1])]):
            parts += [bar(cluster + 1, begin, end, _CAST[number % 2], tall=0.7 * LANE),
                      bar(cluster + 1, end, written, _RESULTS, top=0.7 * LANE, tall=0.3 * LANE)]
    for number, (name, colour) in enumerate((("load", _LOAD), ("cast", _CAST[0]), ("next cast", _CAST[1]),
                                             ("results", _RESULTS))):
        y = TOP + 12 + 18 * number
        parts += [f'<rect x="{right + 12}" y="{y - 9}" width="12" height="10" fill="{colour}"/>',
                  f'<text x="{right + 30}" y="{y}">{name}</text>']
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*parts, "</svg>", ""]))
