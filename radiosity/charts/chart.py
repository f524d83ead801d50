"""Line charts as SVG, with nothing but text."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

__all__ = ["COLOURS", "Line", "ticks", "write_chart"]

WIDTH, HEIGHT = 720, 440
LEFT, RIGHT, TOP, BOTTOM = 60, 200, 40, 50
# Distinguished also by those who do not see all colours.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


@dataclass(frozen=True, kw_only=True)
class Line:
    """Points by ascending x; those that are not finite are left out. ``ends_at`` is marked on the x axis."""

    name: str
    x: np.ndarray
    y: np.ndarray
    ends_at: float | None = None


def write_chart(path: Path, lines: list[Line], *, title: str, x_name: str, y_name: str, y_top: float) -> None:
    """One chart; what is above ``y_top`` is cut off."""
    x_top = max(float(np.max(line.x)) for line in lines) * 1.02
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM

    def position(x, y):
        return LEFT + x / x_top * (right - LEFT), bottom - y / y_top * (bottom - TOP)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
             'font-size="12">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
             f'<text x="{LEFT}" y="24" font-size="15">{escape(title)}</text>',
             f'<text x="{(LEFT + right) / 2}" y="{HEIGHT - 12}" text-anchor="middle">{escape(x_name)}</text>',
             f'<text transform="translate(16 {(TOP + bottom) / 2}) rotate(-90)" text-anchor="middle">{escape(y_name)}'
             '</text>', f'<clipPath id="inside"><rect x="{LEFT}" y="{TOP}" width="{right - LEFT}" '
             f'height="{bottom - TOP}"/></clipPath>']
    for tick in ticks(x_top):
        x, _ = position(tick, 0)
        parts += [f'<path d="M{x:.1f} {TOP}V{bottom}" stroke="#ddd"/>',
                  f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{tick:g}</text>']
    for tick in ticks(y_top):
        _, y = position(0, tick)
        parts += [f'<path d="M{LEFT} {y:.1f}H{right}" stroke="#ddd"/>',
                  f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>']
    for number, line in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        known = np.isfinite(line.y)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(*position(line.x[known], line.y[known]), strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2" '
                     'clip-path="url(#inside)"/>')
        if line.ends_at is not None:
            x, _ = position(line.ends_at, 0)
            parts.append(f'<path d="M{x:.1f} {bottom}l-4 8h8z" fill="{colour}"/>')
        y = TOP + 10 + 18 * number
        parts += [f'<path d="M{right + 10} {y - 4}h20" stroke="{colour}" stroke-width="2"/>',
                  f'<text x="{right + 36}" y="{y}">{escape(line.name)}</text>']
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*parts, "</svg>", ""]))


def ticks(top: float) -> np.ndarray:
    """Round numbers up to ``top``."""
    step = 10 ** np.floor(np.log10(top / 4))
    step *= next(factor for factor in (1, 2, 5, 10) if top / (step * factor) <= 8)
    return np.arange(0, top + step / 1000, step).round(6)
