"""Counts of rays by their purpose."""

import time
from contextlib import contextmanager
from threading import Lock

from golden.base.spread import Spread
from golden.cast.ray_frusta import FrustumHits
from golden.cast.rays import Hits, Rays
from golden.cast.shadow_rays import ShadowHits, ShadowRays

__all__ = ["Tally"]

# Of all tallies: workers are sent casters that count, which a lock of their own could not follow.
_COUNTING = Lock()


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

    def over(self, spread: Spread) -> Spread:
        """A `Spread` that counts the rays of its work here, wherever that is done."""
        def counted(function, parts):
            for part, (result, kinds) in spread(_Counted(self, function), parts):
                self.add(kinds)
                yield part, result
        return counted

    def taken(self) -> dict[str, dict[str, int]]:
        """The counts since the last call, which begin anew at 0."""
        kinds = {kind: dict(counts) for kind, counts in self.kinds.items()}
        for counts in self.kinds.values():
            counts.update(dict.fromkeys(counts, 0))
        return kinds

    def add(self, kinds: dict[str, dict[str, int]]) -> None:
        """Add the counts that another tally has taken."""
        for kind, counts in kinds.items():
            for name, count in counts.items():
                self.kinds[kind][name] += count

    @contextmanager
    def stage(self, name: str):
        """Times a stage."""
        begin = time.perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin


class _Counted:
    """A function whose results come with the counts of its rays."""

    def __init__(self, tally, function):
        self._tally, self._function = tally, function

    def __call__(self, *arguments):
        before = self._tally.taken()
        result = self._function(*arguments)
        kinds = self._tally.taken()
        self._tally.add(before)
        return result, kinds


class CountingCaster:
    """A caster of rays or frusta that counts its work, in any number of threads."""

    def __init__(self, caster, counts: dict[str, int]):
        self._caster, self._counts = caster, counts

    def nearest(self, rays: Rays) -> Hits:
        """The caster's nearest hits."""
        return self.count(self._caster.nearest(rays))

    def any_hit(self, rays: Rays) -> Hits:
        """The caster's any hits."""
        return self.count(self._caster.any_hit(rays))

    def hemispheres(self, *arguments) -> FrustumHits:
        """The caster's hemispheres, counted."""
        return self._counting(self._caster.hemispheres(*arguments))

    def dense_hemispheres(self, *arguments):
        """The caster's hemispheres with finer rays, counted with those that finer ones replace."""
        cast = self._caster.dense_hemispheres(*arguments)

        def counted(number):
            weight, rays, hits, count = cast(number)
            self._add(count, int((hits.patch >= 0).sum()), hits)
            return weight, rays, hits, count
        return counted

    def screen(self, *arguments) -> FrustumHits:
        """The caster's screen, counted."""
        return self._counting(self._caster.screen(*arguments))

    def shadows(self, rays: ShadowRays) -> ShadowHits:
        """The caster's shadow rays; those that it cast are counted."""
        hits = self._caster.shadows(rays)
        self._add(int(hits.cast.sum()), int(hits.blocked.sum()), hits)
        return hits

    def _counting(self, cast):
        return lambda *rays: self.count(cast(*rays))

    def count(self, hits: Hits) -> Hits:
        """The hits, which another caster has found, counted."""
        self._add(len(hits.patch), int((hits.patch >= 0).sum()), hits)
        return hits

    def _add(self, rays, met, hits):
        found = {"rays": rays, "hits": met, "tests": int(hits.tests.sum()), "steps": int(hits.steps.sum())}
        with _COUNTING:
            for name, count in found.items():
                self._counts[name] += count
