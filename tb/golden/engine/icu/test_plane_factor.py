from fractions import Fraction

import numpy as np
import pytest

from golden.engine.icu.plane_factor import plane_factor
from tb.golden.engine.icu.patches import CONFIG, KINDS, hard_patches

NUMBERS = CONFIG.numbers


def exact_plane(patch):
    """N and V = N . V_0 of one patch in Python integers."""
    v = [[int(x) for x in vertex] for vertex in patch]
    a, b = ([v[end][k] - v[start][k] for k in range(3)] for start, end in ((0, 2), (1, 3)))
    n = [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]
    return n, sum(n[k] * v[0][k] for k in range(3))


@pytest.mark.parametrize("kind", KINDS)
def test_m_is_n_over_v_to_22_bits(kind):
    patches = hard_patches(kind, 3, 200)
    factor = plane_factor(patches, NUMBERS)
    for patch, mantissa, exponent, dropped in zip(patches, factor.mantissa.tolist(), factor.exponent.tolist(),
                                                  factor.dropped.tolist(), strict=True):
        n, v = exact_plane(patch)
        assert dropped == (abs(v) <= 2 * sum(map(abs, n)))
        if dropped:
            assert mantissa == [0, 0, 0]
            continue
        assert 2**23 <= max(map(abs, mantissa)) < 2**24
        unit = Fraction(2) ** (exponent - NUMBERS.vector_fraction)
        worst = max(abs(mantissa[k] * unit - Fraction(n[k], v)) for k in range(3))
        assert worst <= max(abs(Fraction(x, v)) for x in n) / 2**22


def test_the_largest_vertices_fit():
    top = 2**23 - 1
    corners = np.array([[x, y, z] for x in (-top, top) for y in (-top, top) for z in (-top, top)])
    patches = corners[np.random.default_rng(5).integers(8, size=(3000, 4))]
    factor = plane_factor(patches, NUMBERS)
    assert not factor.dropped.all()


def test_a_plane_within_two_units_of_the_origin_is_dropped_and_one_at_three_is_not():
    square = np.array([[-1000, -1000, 0], [1000, -1000, 0], [1000, 1000, 0], [-1000, 1000, 0]])
    heights = np.arange(-4, 5)
    patches = square + heights[:, None, None] * np.array([0, 0, 1])
    assert plane_factor(patches, NUMBERS).dropped.tolist() == (np.abs(heights) <= 2).tolist()


def test_m_points_from_the_origin_to_the_plane_on_either_side():
    square = np.array([[-1000, -1000, 500], [1000, -1000, 500], [1000, 1000, 500], [-1000, 1000, 500]])
    for patch in (square, square[::-1], -square):
        mantissa = plane_factor(patch[None], NUMBERS).mantissa[0]
        assert (mantissa @ patch.T > 0).all()
