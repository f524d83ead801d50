"""Counts of rays by their purpose."""

import time
from contextlib import contextmanager

from golden.cast.ray_frusta import FrustumHits
from golden.cast.rays import Hits, Rays

__all__ = ["Tally"]


class Tally:
    """Counts of rays, hits, tests and steps by kind of ray, and times of stages.

    Members
    -------
    kinds
        For each kind of ray: ``rays``, ``hits``, ``tests``, ``steps``.
    seconds
        Wall-clock time of each stage, in seconds.
    """

    def __init__(self):
        self.kinds: dict[str, dict[str, int]] = {}
        self.seconds: dict[str, float] = {}

    def counting(self, kind: str, caster) -> "CountingCaster":
        """The caster, with its rays counted as of this kind."""
        return CountingCaster(caster, self.kinds.setdefault(kind, {"rays": 0, "hits": 0, "tests": 0, "steps": 0}))

    @contextmanager
    def stage(self, name: str):
        """Times a stage."""
        begin = time.perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin


class CountingCaster:
    """A caster of rays or frusta that counts its work."""

    def __init__(self, caster, counts: dict[str, int]):
        self._caster, self._counts = caster, counts

    def nearest(self, rays: Rays) -> Hits:
        """The caster's nearest hits."""
        return self._count(self._caster.nearest(rays))

    def any_hit(self, rays: Rays) -> Hits:
        """The caster's any hits."""
        return self._count(self._caster.any_hit(rays))

    def hemispheres(self, *arguments) -> FrustumHits:
        """The caster's hemispheres, counted."""
        return self._counting(self._caster.hemispheres(*arguments))

    def screen(self, *arguments) -> FrustumHits:
        """The caster's screen, counted."""
        return self._counting(self._caster.screen(*arguments))

    def _counting(self, cast):
        return lambda *rays: self._count(cast(*rays))

    def _count(self, hits):
        self._counts["rays"] += len(hits.patch)
        self._counts["hits"] += int((hits.patch >= 0).sum())
        self._counts["tests"] += int(hits.tests.sum())
        self._counts["steps"] += int(hits.steps.sum())
        return hits
