"""Torus steps: a drawing of who holds which ray over time."""

from colorsys import hls_to_rgb
from typing import TYPE_CHECKING

import numpy as np

from radiosity.charts.chart import Bars, lane_figure
from radiosity.machines.torus.torus_run import TorusRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["LOGGED", "steps_figure"]

LOGGED = 6000
"""Walks of a drawing at most."""

# Hues of the rows of the torus, in degrees: a ray has the colour of the node that has its pixel, lighter along a row.
_HUES = 300


def steps_figure(run: TorusRun) -> "Figure":
    """Draw a lane for each node, with a bar for each walk.

    The colour of a bar is that of the node whose pixel the ray is for: bars of other colours are rays that have
    travelled. Shadow rays are narrower. The log has the first walks of the run.
    """
    side, nodes, columns = run.setup.side, run.setup.nodes, run.setup.size[1]
    begin, microseconds, node, pixel, _, is_shadow = run.log.T
    owner = (side * (np.searchsorted(run.boxes.rows, pixel // columns, side="right") - 1)
             + np.searchsorted(run.boxes.columns, pixel % columns, side="right") - 1)
    bars = []
    for whose in range(nodes):
        for shadow, top, bottom in ((0, 0.05, 0.85), (1, 0.3, 0.6)):
            chosen = (owner == whose) & (is_shadow == shadow)
            bars.append(Bars(lane=node[chosen], begin=begin[chosen] / 1e6,
                             end=(begin + microseconds)[chosen] / 1e6, colour=_colour(whose, nodes), top=top,
                             bottom=bottom, name="" if shadow else f"node {whose}"))
    return lane_figure([f"node {number}" for number in range(nodes)], bars, x_name="s",
                       title=f"{run.scene.name}, {run.setup.size[0]} x {columns} pixels: a ray has the colour of the "
                       "node that has its pixel; narrow bars are shadow rays")


def _colour(node, nodes):
    hue, lightness = _HUES * node // max(nodes - 1, 1), 42 + 12 * (node % 2)
    return "#" + "".join(f"{round(255 * part):02x}" for part in hls_to_rgb(hue / 360, lightness / 100, 0.65))
