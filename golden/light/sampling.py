"""Random numbers that depend on their use, not on the order in which they are drawn.

A number is a hash of a seed and of the keys of its use (pixel, sample, bounce), so a picture does not depend on how its
pixels are batched.
"""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["mix", "pixel_ranks", "scrambled", "sobol", "uniform"]

# The whole numbers of the sequence, and those that have no bit of a step: 0x55555555, 0x33333333 ...
_BITS = 32
_WHOLE = (1 << _BITS) - 1
_STEPS = tuple((1 << step, _WHOLE // ((1 << (1 << step)) + 1)) for step in range(5))
# Odd, so that it maps different numbers to different seeds.
_ODD = 0x9E3779B9


def mix(seed, *keys) -> np.ndarray:
    """A 64-bit hash of whole numbers; arrays broadcast."""
    state = np.asarray(seed, dtype=np.uint64)
    with np.errstate(over="ignore"):  # modulo 2^64 on purpose
        for key in keys:
            key = np.asarray(key).astype(np.uint64) + np.uint64(1)
            state = scrambled(state + np.uint64(0x9E3779B97F4A7C15) * key)
    return state


def uniform(state: np.ndarray, dimension: int) -> np.ndarray:
    """Float64 in [0, 1): the number of a use's ``dimension``, the use being a `mix`."""
    return (mix(state, dimension) >> np.uint64(11)) * 2.0**-53


def sobol(state: np.ndarray, count: int, rank: np.ndarray | int = 0) -> np.ndarray:
    """Points of [0, 1)^2 for each use, M x count x 2: the Sobol' sequence, with Owen's scrambling and shuffled.

    2^m points from a multiple of 2^m on lie one in each of 2^m equal rectangles, whatever their shape.

    Parameters
    ----------
    state
        M uses. Those of one state share a sequence; the sequences of two are independent.
    count
        Points of a use.
    rank
        A use has the points ``rank`` * ``count`` to (``rank`` + 1) * ``count`` - 1 of its sequence.
    """
    points = np.empty((len(state), count, 2))
    seeds = np.stack([(mix(state, part) >> np.uint64(_BITS)).astype(np.int64) for part in range(3)], axis=1)
    _fill(seeds, np.broadcast_to(np.asarray(rank, dtype=np.int64), (len(state),)), points)
    return points


def pixel_ranks(column: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Int64 numbers of pixels in Morton's order: those of an aligned square of 2^m x 2^m follow each other.

    As ranks of `sobol` they let the pixels of such squares spread their points together, so the errors of neighbours
    differ in sign and the eye averages them.
    """
    ranks = np.zeros(len(column), dtype=np.int64)
    for bit in range(16):
        ranks |= (column >> bit & 1) << 2 * bit | (row >> bit & 1) << 2 * bit + 1
    return ranks


@compiled
def _fill(seeds, rank, points):
    count = points.shape[1]
    for use in range(len(points)):
        for point in range(count):
            number = rank[use] * count + point
            # Beyond 2^32 points the sequence begins again, scrambled anew.
            again = (number >> _BITS) * _ODD
            number = _reversed(_owen(_reversed(number & _WHOLE), (seeds[use, 2] + again) & _WHOLE))
            points[use, point, 0] = _reversed(_owen(number, (seeds[use, 0] + again) & _WHOLE)) / 2.0**_BITS
            points[use, point, 1] = _reversed(_owen(_second(number), (seeds[use, 1] + again) & _WHOLE)) / 2.0**_BITS


@compiled
def _second(number):
    """The second coordinate, its first bit lowest: bit j is the parity of those bits i of a number with C(i, j) odd."""
    for step, mask in _STEPS:
        number ^= number >> step & mask
    return number


@compiled
def _reversed(number):
    for step, mask in _STEPS:
        number = (number & mask) << step | number >> step & mask
    return number


@compiled
def _owen(number, seed):
    """Flip each bit by a hash of the lower ones (Laine and Karras 2011, with Vegdahl's constants)."""
    number ^= _product(number, 0x3D20ADEA)
    number = (number + seed) & _WHOLE
    number = _product(number, seed >> 16 | 1)
    number ^= _product(number, 0x05526C56)
    return number ^ _product(number, 0x53A22864)


@compiled
def _product(one, other):
    """Modulo 2^32, of numbers below it, without an overflow of int64."""
    return (one * (other & 0xFFFF) + ((one * (other >> 16) & 0xFFFF) << 16)) & _WHOLE


def scrambled(state):
    """The finaliser of the splitmix64 generator, which maps neighbouring numbers far apart."""
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state ^ (state >> np.uint64(31))
