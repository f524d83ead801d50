"""Patch store: which requests of a cluster need a fetch, and which patches it keeps.

Source: Shen 1993, section 5.2.4.1, for the I-structure.
"""

__all__ = ["KEPT_OF", "PatchStore"]

# Of so many misses that meet another patch in their frame one replaces it, a power of two.
KEPT_OF = 16


class PatchStore:
    """A memory of patches by frame: patch p belongs into frame p modulo ``frames``.

    A patch that is not there is fetched. It is kept if its frame is empty, and at every `KEPT_OF`-th miss that meets
    another patch. What is kept follows from the order of the requests alone, also of requests that overlap.

    Parameters
    ----------
    frames
        Patches that it keeps.

    Members
    -------
    hits, misses
        Requests without and with a fetch.
    """

    def __init__(self, frames: int):
        self._frames, self._kept, self._conflicts = frames, {}, 0
        self.hits = self.misses = 0

    def request(self, patch: int) -> bool:
        """Whether the patch is there, or in flight to it."""
        frame = patch % self._frames
        kept = self._kept.get(frame)
        if kept == patch:
            self.hits += 1
            return True
        self.misses += 1
        if kept is not None:
            self._conflicts += 1
        if kept is None or self._conflicts % KEPT_OF == 0:
            self._kept[frame] = patch
        return False

    def __contains__(self, patch: int) -> bool:
        """Whether its frame keeps the patch, or will keep the one that is fetched."""
        return self._kept.get(patch % self._frames) == patch

    def clear(self):
        """All frames are empty from now on."""
        self._kept, self._conflicts = {}, 0
