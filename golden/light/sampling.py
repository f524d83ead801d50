"""Random numbers that depend on their use, not on the order in which they are drawn.

A number is a hash of a seed and of the keys of its use (pixel, sample, bounce), so a picture does not depend on how its
pixels are batched.
"""

import numpy as np

from golden.compiled import compiled

__all__ = ["lattice", "mix", "uniform"]

# Of the points (k / n, k g) modulo 1 the first coordinates are evenly spaced; the golden ratio g spreads the second
# ones evenly for every n.
_GOLDEN = (5**0.5 - 1) / 2


def mix(seed, *keys) -> np.ndarray:
    """A 64-bit hash of whole numbers; arrays broadcast."""
    state = np.asarray(seed, dtype=np.uint64)
    with np.errstate(over="ignore"):  # modulo 2^64 on purpose
        for key in keys:
            key = np.asarray(key).astype(np.uint64) + np.uint64(1)
            state = _scramble(state + np.uint64(0x9E3779B97F4A7C15) * key)
    return state


def uniform(state: np.ndarray, dimension: int) -> np.ndarray:
    """Float64 in [0, 1): the number of a use's ``dimension``, the use being a `mix`."""
    return (mix(state, dimension) >> np.uint64(11)) * 2.0**-53


def lattice(state: np.ndarray, count: int, rank: np.ndarray | int = 0, ranks: int = 1) -> np.ndarray:
    """Points of [0, 1)^2 for each use, M x count x 2: a rank-1 lattice with a random shift.

    Parameters
    ----------
    state
        M uses.
    count
        Points of a use.
    rank, ranks
        Uses of equal states and ranks 0 to ``ranks`` - 1 have different points of one lattice.
    """
    points = np.empty((len(state), count, 2))
    _fill(uniform(state, 0), uniform(state, 1), np.broadcast_to(rank, (len(state),)), ranks, points)
    return points


@compiled
def _fill(shift_x, shift_y, rank, ranks, points):
    count = points.shape[1]
    step = 1 / (count * ranks)
    for use in range(len(points)):
        for point in range(count):
            number = rank[use] + ranks * point
            x, y = shift_x[use] + number * step, shift_y[use] + number * _GOLDEN
            points[use, point, 0], points[use, point, 1] = x - np.floor(x), y - np.floor(y)


def _scramble(state):
    """The finaliser of the splitmix64 generator, which maps neighbouring numbers far apart."""
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state ^ (state >> np.uint64(31))
