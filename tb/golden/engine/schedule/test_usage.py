"""Effectiveness and usage frequency on cases worked out by hand."""

import numpy as np

from golden.engine.schedule.usage import cumulative_frequency, effectiveness, usage_order


def test_usage_order_is_most_used_first_and_the_smaller_number_of_equals():
    assert usage_order([3, 7, 0, 7, 1]).tolist() == [1, 3, 0, 4, 2]


def test_effectiveness_is_the_served_share_of_what_the_best_would_serve():
    # The sparse casting prefers patch 0, the dense ones patch 2; patch 3 was not found.
    dense, sparse = [10, 20, 40, 30], [5, 3, 4, 0]
    assert np.allclose(effectiveness(dense, sparse), [10 / 40, 50 / 70, 70 / 90])


def test_effectiveness_is_one_where_the_best_have_no_references_too():
    assert effectiveness([0, 0, 0], [3, 0, 2]).tolist() == [1, 1]
    assert effectiveness([0, 5, 0], [3, 0, 2]).tolist() == [0, 0]
    assert effectiveness([4, 5, 6], [0, 0, 0]).tolist() == []


def test_cumulative_frequency_is_the_share_of_all_references():
    assert cumulative_frequency([10, 20, 40, 30], [0, 2]) == 0.5
    assert cumulative_frequency([10, 20, 40, 30], []) == 0
    assert cumulative_frequency([0, 0], [1]) == 1
