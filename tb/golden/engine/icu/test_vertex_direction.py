import numpy as np
import pytest

from golden.engine.config import Numbers
from golden.engine.icu.vertex_direction import vertex_direction


def vertices(count=5000):
    random = np.random.default_rng(1)
    return random.integers(-(2**23) + 1, 2**23, (count, 3)) >> random.integers(0, 24, (count, 1))


@pytest.mark.parametrize("bits", [10, 17])
def test_the_largest_component_fills_the_bits_and_the_error_is_one_unit_at_most(bits):
    v = vertices()
    v = v[v.any(axis=1)]
    direction, exponent = vertex_direction(v, Numbers(vertex_bits=bits))
    largest = np.abs(direction).max(axis=1)
    assert largest.min() >= 2 ** (bits - 1)
    assert largest.max() < 2**bits
    error = np.abs(direction * 2.0 ** exponent[:, None] - v) / 2.0 ** exponent[:, None]
    assert error.max() <= 1
    assert (error[largest < 2**bits - 1] <= 0.5).all()


def test_short_vertices_are_exact():
    v = np.array([[1, 0, 0], [5, -3, 2], [2**17 - 1, 1, -1]])
    direction, exponent = vertex_direction(v, Numbers())
    assert (direction == v << -exponent[:, None]).all()


def test_a_magnitude_that_would_round_up_to_a_bit_more_stays():
    direction, exponent = vertex_direction(np.array([[2**18 - 1, -(2**18) + 1, 3]]), Numbers())
    assert direction.tolist() == [[2**17 - 1, -(2**17) + 1, 2]]
    assert exponent.tolist() == [1]


def test_opposite_vertices_have_opposite_directions_and_the_origin_none():
    v = vertices()
    assert (vertex_direction(v, Numbers())[0] == -vertex_direction(-v, Numbers())[0]).all()
    assert (vertex_direction(np.zeros((1, 3), int), Numbers())[0] == 0).all()
