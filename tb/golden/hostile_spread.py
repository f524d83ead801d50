"""A partner whose spans of work end in another order than that in which they are given."""

import numpy as np

__all__ = ["HOSTILE", "HostileSpread"]


class HostileSpread:
    """A `golden.base.spread.Spread`, and the workers of one, that gives results in another order.

    Parameters
    ----------
    seed
        Draws the order. None: the last span comes first.

    Members
    -------
    turned
        Calls in which a span came before one in front of it.
    """

    def __init__(self, seed: int | None = None):
        self._seed, self.turned = seed, 0

    def __repr__(self):
        return "reversed" if self._seed is None else f"shuffled {self._seed}"

    def __call__(self, function, parts):
        """Compute all spans, then give them."""
        parts = list(parts)
        results = [(part, function(*part)) for part in parts]
        order = np.arange(len(parts))[::-1]
        if self._seed is not None:
            drawn = np.random.default_rng(self._seed).permutation(len(parts))
            order = drawn if (np.diff(drawn) < 0).any() else order
        self.turned += len(parts) > 1
        yield from (results[number] for number in order)

    def spread(self, scene, *, frusta, rays) -> "HostileSpread":
        """What `radiosity.workers.pool.WorkerPool` gives for a scene and its casters."""
        return self


HOSTILE = (None, 1, 2)
"""Seeds that tests of all users of a spread take."""
