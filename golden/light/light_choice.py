"""Which lamps shadow rays go to."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["choose_lights"]


def choose_lights(weight: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, ...]:
    """Lights for S samples at each of M points, in proportion to their weights; K samples are at a point with a light.

    Parameters
    ----------
    weight
        M x L weights of the lights, at least 0.
    place
        M x S numbers from 0 up to 1: each sample's share of the cumulative weight.

    Returns
    -------
    sample, light, place, density
        K each: number of the sample among the M x S, its light, its place within that light's part of the cumulative
        weight (0 to 1), and the light's share of all weight.
    """
    count = place.size
    sample, light, within, density = (
        np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64), np.empty(count), np.empty(count))
    end = _choose(weight, place, sample, light, within, density)
    return sample[:end], light[:end], within[:end], density[:end]


@compiled
def _choose(weight, place, sample, light, within, density):
    end, samples = 0, place.shape[1]
    ends = np.empty(weight.shape[1])
    for point in range(len(weight)):
        total, last = 0.0, -1
        for number in range(len(ends)):
            total += weight[point, number]
            ends[number] = total
            if weight[point, number] > 0:
                last = number
        if last < 0:
            continue
        for number in range(samples):
            target = place[point, number] * total
            # A target that rounds up to the total belongs to the last light of nonzero weight.
            chosen = min(np.searchsorted(ends, target, side="right"), last)
            chance = weight[point, chosen]
            sample[end], light[end] = point * samples + number, chosen
            within[end] = min(max((target - (ends[chosen] - chance)) / chance, 0.0), 1.0)
            density[end] = chance / total
            end += 1
    return end
