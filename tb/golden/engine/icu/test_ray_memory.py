import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.icu.ray_memory import RayMemory
from tb.golden.engine.icu.patches import CONFIG


def hits(seed, count=5000):
    random = np.random.default_rng(seed)
    return random.integers(0, 64, count), random.integers(1, 30, count) * 2**19, random.integers(0, 1000, count)


def test_larger_inverse_distance_wins_and_ties_go_to_the_smaller_patch():
    memory = RayMemory(3, CONFIG)
    memory.update(np.array([0, 0, 1, 1, 1]), np.array([7, 9, 5, 5, 4]), np.array([1, 8, 6, 3, 0]))
    assert memory.inverse.tolist() == [9, 5, 0]
    assert memory.patch.tolist() == [8, 3, -1]
    memory.update(np.array([0, 1, 1]), np.array([9, 5, 5]), np.array([9, 2, 4]))
    assert memory.patch.tolist() == [8, 2, -1]


def test_the_order_of_updates_does_not_matter():
    ray, inverse, patch = hits(1)
    results = set()
    for seed in range(20):
        memory = RayMemory(64, CONFIG)
        for part in np.array_split(np.random.default_rng(seed).permutation(len(ray)), seed + 1):
            memory.update(ray[part], inverse[part], patch[part])
        results.add((memory.inverse.tobytes(), memory.patch.tobytes()))
    assert len(results) == 1


def test_the_largest_numbers_fit():
    memory = RayMemory(2, CONFIG)
    memory.update(np.array([0, 1]), np.array([CONFIG.numbers.inverse.high, 1]), np.array([0, 2**31 - 2]))
    assert memory.inverse.tolist() == [2**24 - 1, 1]
    assert memory.patch.tolist() == [0, 2**31 - 2]


def test_more_rays_than_it_holds_are_refused():
    RayMemory(4096, PRESETS["tiny"])
    with pytest.raises(InputError, match=r"^frustum: Rays must be at most icu\.rays \(4096\), not 4097$"):
        RayMemory(4097, PRESETS["tiny"])
