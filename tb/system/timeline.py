"""What is busy when: a chart from counters that were read now and then."""

from pathlib import Path

import numpy as np

from golden.config import Config
from hw.formats import GRID_GROUP
from tb.bench.chart import Line, write_chart

__all__ = ["shares", "write_timeline"]


def shares(looks: list[tuple[int, list[dict[str, int]]]], config: Config) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Middle of each stretch between two looks, and of each unit the share of the stretch in which it was busy.

    Of all clusters together. A patch takes intersection four cycles at least.
    """
    pipelines = config.ctu.traversal_pipelines(config.noc.nodes)
    units = {"tests": ("intersection_tested", 1), "patches": ("intersection_patches", 4),
             "steps": ("traversal_steps", 1 / pipelines), "grid rays": ("traversal_rays", 1),
             "requests": ("traversal_requests", 1 / GRID_GROUP)}
    at = np.array([cycle for cycle, _ in looks])
    length = np.maximum(np.diff(at), 1)
    busy = {}
    for unit, (name, cycles) in units.items():
        count = np.array([np.mean([one[name] for one in counters]) for _, counters in looks])
        # What the frustum before has counted is forgotten when this one begins.
        busy[unit] = np.maximum(np.diff(count), 0) * cycles / length
    return (at[1:] + at[:-1]) / 2, busy


def write_timeline(path: Path, looks: list, config: Config, *, title: str) -> None:
    """The chart."""
    at, busy = shares(looks, config)
    write_chart(path, [Line(name=name, x=at, y=values) for name, values in busy.items()], title=title,
                x_name="cycle", y_name="share of cycles", y_top=1.0)
