"""Patch tags: the address that steers a patch through the distributor, from the cuts of the sections."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from golden.engine.icu.window import Window
from golden.engine.schedule.classification import rays_inside
from golden.engine.schedule.sections import Partition

__all__ = ["PatchTags", "patch_tags", "reached_sections"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PatchTags:
    """The tags of P patches for 2^L sections.

    Parameters
    ----------
    side
        P x L bool: the patch is on the high side of the cuts of that level; False where it is on both.
    both
        P x L bool: it is on both sides.
    sent
        P bool: it reaches a section at all.
    """

    side: np.ndarray
    both: np.ndarray
    sent: np.ndarray

    def destinations(self, patch: int) -> np.ndarray:
        """Numbers of the sections to which the switches route a patch, ascending."""
        if not self.sent[patch]:
            return np.empty(0, dtype=np.int64)
        parts = np.zeros(1, dtype=np.int64)
        for side, both in zip(self.side[patch], self.both[patch], strict=True):
            sides = np.arange(2) if both else np.array([int(side)])
            parts = (2 * parts[:, None] + sides).ravel()
        return parts

    def links(self, patch: int) -> int:
        """Links of the tree that a patch occupies: that to the root, and one for each side of each switch passed."""
        if not self.sent[patch]:
            return 0
        return 1 + int(np.cumprod(1 + self.both[patch].astype(np.int64)).sum())


def patch_tags(partition: Partition, windows: Sequence[Window]) -> PatchTags:
    """The tags of patches.

    Bit l is the side of the level-l cut. Each part has a cut of its own. A patch that is on both sides of one, or on
    different sides of two, is on both sides of that level: then the switches route it to more sections than its window
    meets, and never to fewer.

    Parameters
    ----------
    partition
        The sections.
    windows
        Windows of P patches in each frustum that is cast with the partition: a patch is where it is in any of them.
        A patch without rays in all of them is not sent.

    Source: Shen & Deprettere, sections 1.3.2 and 1.3.3; they leave open where a patch on both sides goes.
    """
    count = len(windows[0].row_first)
    side, both = np.zeros((2, count, len(partition.levels) - 1), dtype=bool)
    for level, parts in enumerate(partition.levels[1:]):
        reached = np.any([_reached(window, parts, partition.columns) for window in windows], axis=0)
        low, high = reached[:, 0::2].any(axis=1), reached[:, 1::2].any(axis=1)
        side[:, level], both[:, level] = high & ~low, high & low
    return PatchTags(side=side, both=both, sent=np.any([window.rays > 0 for window in windows], axis=0))


def reached_sections(partition: Partition, window: Window) -> np.ndarray:
    """Whether the window of each patch meets each section: P x 2^L bool."""
    return _reached(window, partition.levels[-1], partition.columns)


def _reached(window, parts, columns):
    return np.stack([rays_inside(window, part, columns) > 0 for part in parts], axis=1)
