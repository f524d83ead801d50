"""The utilization of each unit over time, from samples of the counters."""

import numpy as np

from golden.engine.config import Config
from hw.ctu.ctu_formats import GRID_GROUP

__all__ = ["SAMPLED", "utilization"]

# Counters that samples must hold.
SAMPLED = ("intersection_tested", "intersection_patches", "traversal_steps", "traversal_rays", "traversal_requests")


def utilization(samples: list[tuple[int, list[dict[str, int]]]],
                config: Config) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The middle of each interval between two samples, and for each unit its share of busy cycles in the interval.

    The share is the mean over all clusters. A patch occupies intersection for four cycles or more.

    Parameters
    ----------
    samples
        Cycle and `SAMPLED` counters of each cluster, by ascending cycle; the first is of the start.
    """
    pipelines = config.ctu.traversal_pipelines(config.noc.clusters)
    units = {"tests": ("intersection_tested", 1), "patches": ("intersection_patches", 4),
             "steps": ("traversal_steps", 1 / pipelines), "grid rays": ("traversal_rays", 1),
             "requests": ("traversal_requests", 1 / GRID_GROUP)}
    at = np.array([cycle for cycle, _ in samples])
    length = np.maximum(np.diff(at), 1)
    busy = {}
    for unit, (name, cycles) in units.items():
        count = np.array([np.mean([one[name] for one in counters]) for _, counters in samples])
        # The counters of the frustum before are cleared when this one starts.
        busy[unit] = np.maximum(np.diff(count), 0) * cycles / length
    return (at[1:] + at[:-1]) / 2, busy
