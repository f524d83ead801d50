"""Torus steps: a drawing of who holds which ray over time."""

from pathlib import Path

import numpy as np

from golden.base.output import whole_file
from radiosity.machines.torus.torus_run import TorusRun

__all__ = ["LOGGED", "steps_svg", "write_steps"]

LOGGED = 6000
"""Walks of a drawing at most."""

_WIDTH, _LANE, _LEFT, _TOP = 900, 18, 70, 34
# Hues of the rows of the torus: a ray has the colour of the node that has its pixel, lighter along a row.
_HUES = 300


def steps_svg(run: TorusRun) -> str:
    """Draw a lane for each node, with a bar for each walk.

    The colour of a bar is that of the node whose pixel the ray is for: bars of other colours are rays that have
    travelled. Shadow rays are narrower. The log has the first walks of the run.
    """
    side, nodes = run.setup.side, run.setup.nodes
    log = run.log
    end = int((log[:, 0] + log[:, 1]).max()) if len(log) else 1
    start = int(log[0, 0]) if len(log) else 0
    scale = _WIDTH / max(end - start, 1)
    row, column = log[:, 3] // run.setup.size[1], log[:, 3] % run.setup.size[1]
    owner = (side * (np.searchsorted(run.boxes.rows, row, side="right") - 1)
             + np.searchsorted(run.boxes.columns, column, side="right") - 1)
    height = _TOP + nodes * _LANE + 30
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{_LEFT + _WIDTH + 20}" height="{height}" '
             'font-family="sans-serif" font-size="11">',
             f'<title>{run.scene.name}: walks of rays on {nodes} nodes over time</title>',
             f'<rect width="{_LEFT + _WIDTH + 20}" height="{height}" fill="white"/>',
             f'<text x="{_LEFT}" y="18">{run.scene.name}, {run.setup.size[0]} x {run.setup.size[1]} pixels: a ray has '
             'the colour of the node that has its pixel; narrow bars are shadow rays</text>']
    for node in range(nodes):
        top = _TOP + node * _LANE
        lines += [f'<rect x="{_LEFT - 12}" y="{top + 3}" width="9" height="9" fill="{_colour(node, nodes)}"/>',
                  f'<text x="4" y="{top + 12}">node {node}</text>',
                  f'<line x1="{_LEFT}" x2="{_LEFT + _WIDTH}" y1="{top + 15}" y2="{top + 15}" stroke="#ddd"/>']
    for (begin, us, node, _, _, is_shadow), whose in zip(log.tolist(), owner.tolist(), strict=True):
        top, tall = _TOP + node * _LANE + (5 if is_shadow else 1), 6 if is_shadow else 14
        lines.append(f'<rect x="{_LEFT + (begin - start) * scale:.1f}" y="{top}" width="{max(us * scale, 0.3):.1f}" '
                     f'height="{tall}" fill="{_colour(whose, nodes)}"/>')
    lines += [f'<text x="{_LEFT}" y="{height - 10}">{start / 1e6:.2f} s</text>',
              f'<text x="{_LEFT + _WIDTH}" y="{height - 10}" text-anchor="end">{end / 1e6:.2f} s</text>', "</svg>"]
    return "\n".join(lines) + "\n"


def _colour(node, nodes):
    return f"hsl({_HUES * node // max(nodes - 1, 1)},65%,{42 + 12 * (node % 2)}%)"


def write_steps(path: Path, run: TorusRun) -> None:
    """Write the drawing, atomically."""
    with whole_file(path) as part:
        part.write_text(steps_svg(run))
