import numpy as np

from golden.frustum import Hemisphere
from golden.icu.collector import collect


def test_sums_of_a_closed_scene_are_one_exactly():
    hemisphere = Hemisphere(2048, 64)
    patch = np.random.default_rng(1).integers(0, 9, len(hemisphere))
    sums = collect(patch, hemisphere.weights, 9)
    assert int(sums.sum()) == 2**40
    assert sums[3] == sum(hemisphere.weights[patch == 3].tolist())


def test_rays_without_a_hit_count_for_no_patch():
    assert collect(np.array([-1, 1, -1, 1]), np.array([8, 4, 2, 1]), 3).tolist() == [0, 5, 0]


def test_sums_of_clusters_add_up():
    hemisphere = Hemisphere(64, 16)
    patch = np.random.default_rng(2).integers(-1, 5, len(hemisphere))
    parts = sum(collect(patch[part], hemisphere.weights[part], 5) for part in np.array_split(np.arange(1024), 7))
    assert (parts == collect(patch, hemisphere.weights, 5)).all()
