"""Patch store: which requests of a cluster need a fetch.

Source: Shen 1993, section 5.2.4.1, for the I-structure.
"""

__all__ = ["PatchStore"]


class PatchStore:
    """A memory of patches by frame: patch p belongs into frame p modulo ``frames``.

    Requests come one after the other: each is answered before the next one. Overlapping requests are served by fewer or
    more fetches, with the same patches.

    Parameters
    ----------
    frames
        Patches that it keeps.
    """

    def __init__(self, frames: int):
        self._frames, self._kept = frames, {}

    def request(self, patch: int) -> bool:
        """Whether the patch is there; it is from now on, and the one that was in its frame is not."""
        frame = patch % self._frames
        there, self._kept[frame] = self._kept.get(frame) == patch, patch
        return there
