"""The choice of a lamp: shares of samples, places within the lamps' parts, and lamps that get none."""

import numpy as np
import pytest

from golden.light.light_choice import choose_lights

WEIGHT = np.array([[0.0, 3.0, 0.0, 1.0, 0.0]])


def test_lights_share_the_samples_by_weight_and_each_part_is_covered_evenly():
    place = (np.arange(4000)[None] + 0.5) / 4000
    sample, light, within, density = choose_lights(WEIGHT, place)
    assert sample.tolist() == list(range(4000))
    assert np.bincount(light, minlength=5).tolist() == [0, 3000, 0, 1000, 0]
    assert density == pytest.approx(np.where(light == 1, 0.75, 0.25))
    for number, count in ((1, 3000), (3, 1000)):
        np.testing.assert_allclose(within[light == number], (np.arange(count) + 0.5) / count, atol=1e-9)


def test_ends_of_the_line_belong_to_lights_with_a_weight():
    _, light, within, _ = choose_lights(WEIGHT, np.array([[0.0, 0.75, 1.0]]))
    assert light.tolist() == [1, 3, 3]
    assert within.tolist() == [0.0, 0.0, 1.0]


def test_points_without_a_light_have_no_samples():
    weight = np.concatenate([np.zeros((1, 5)), WEIGHT, np.zeros((1, 5)), WEIGHT])
    sample, light, _, _ = choose_lights(weight, np.full((4, 2), [0.1, 0.9]))
    assert sample.tolist() == [2, 3, 6, 7]
    assert light.tolist() == [1, 3, 1, 3]
