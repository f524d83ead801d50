"""Ray work: how long a node computes on a pixel, faults aside."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from golden.cast.rays import Hits
from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["RayWork"]


@dataclass(frozen=True, kw_only=True)
class RayWork(TimingNumbers):
    """Nanoseconds of a ray, of a cell that it passes, and of a test.

    The source has none. Ours are operations of 5.87 us, as in `NodeTiming`: 8 to pass a cell (Amanatides and Woo:
    comparisons, an addition, a load and a branch), 30 to test a polygon (plane, distance, and its edges), and 100 to
    make and shade a ray.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below 0, or a ray takes no time.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("ray",)

    ray: int = 587_000
    step: int = 46_960
    test: int = 176_100

    def of_groups(self, hits: Hits, group: np.ndarray, groups: int) -> np.ndarray:
        """G int64: ns of groups of rays, such as those of a pixel.

        Parameters
        ----------
        hits, group, groups
            Of R rays, the group of each, and G.
        """
        of_rays = self.ray + self.step * hits.steps + self.test * hits.tests
        return np.bincount(group, of_rays, groups).astype(np.int64)
