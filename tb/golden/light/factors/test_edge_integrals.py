import numpy as np
import pytest

from golden.light.factors.edge_integrals import edge_integrals


def by_halving(first, second, *, depth=22):
    """The integral by Gauss points on squares that shrink towards the place of the smallest distance."""
    knots, gauss = np.polynomial.legendre.leggauss(10)
    lengths = [np.linalg.norm(ends[1] - ends[0]) for ends in (first, second)]
    cells, total = np.array([[0.0, 1.0, 0.0, 1.0]]), 0.0
    for level in range(depth):
        s, t = (np.linspace(cells[:, k], cells[:, k + 1], 3, axis=1) for k in (0, 2))
        low_s, low_t = (np.repeat(s[:, :2], 2, axis=1).ravel(), np.tile(t[:, :2], 2).ravel())
        width = cells[0, 1] - cells[0, 0]
        u, v = (low[:, None] + width / 4 * (knots + 1) for low in (low_s, low_t))
        place = [ends[0] + x[..., None] * (ends[1] - ends[0]) for ends, x in ((first, u), (second, v))]
        r = np.linalg.norm(place[0][:, :, None] - place[1][:, None], axis=-1)
        near = r.min(axis=(1, 2)) < width * max(lengths) if level < depth - 1 else np.zeros(len(r), dtype=bool)
        total += np.einsum("cij,i,j->", np.log(r[~near]), gauss, gauss) * (width / 4)**2
        cells = np.stack([low_s, low_s + width / 2, low_t, low_t + width / 2], axis=1)[near]
        if not len(cells):
            break
    return total * np.prod(lengths)


CASES = {
    "parallel": [[(0, 0, 0), (2, 0, 0)], [(0.5, 1, 0), (3, 1, 0)]],
    "opposite": [[(0, 0, 0), (2, 0, 0)], [(3, 0.1, 0), (0.5, 0.1, 0)]],
    "with a common end": [[(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1, 2, 1)]],
    "that cross": [[(-1, 0, 0), (1, 0.2, 0)], [(0, -1, 0), (0, 2, 0)]],
    "skew and near": [[(-1, 0, 0), (1, 0.3, 0)], [(0.2, -1, 0.01), (0, 2, 0.02)]],
    "skew and far": [[(0, 0, 0), (1, 0, 0)], [(0, 3, 1), (1, 3.5, 2)]],
    "at 8 mrad": [[(0, 0, 0), (1, 0, 0)], [(0.2, 0.3, 0.1), (1.4, 0.31, 0.1)]],
    "at 8 mrad with a common end": [[(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1.5, 0.012, 0)]],
}


@pytest.mark.parametrize("ends", CASES.values(), ids=CASES)
def test_segments(ends):
    first, second = np.array(ends, dtype=float)
    expected = by_halving(first, second)
    for one, other in ((first, second), (second, first), (first[::-1], second)):
        assert edge_integrals(one[None], other[None])[0] == pytest.approx(expected, rel=0, abs=3e-9)


def test_one_segment_with_itself():
    ends = np.array([[(1, 2, 3), (1, 4, 3)]], dtype=float)
    assert edge_integrals(ends, ends)[0] == pytest.approx(4 * np.log(2) - 6, rel=0, abs=1e-13)


@pytest.mark.parametrize("limit", [1e-11, 1e-2])
def test_the_methods_agree_where_one_hands_over_to_the_other(limit):
    first = np.array([[(0, 0, 0), (1, 0, 0)]], dtype=float)
    below, above = (edge_integrals(first, np.array([[(0.3, 0.4, 0.1), (1.3, 0.4 + sine, 0.1)]]))[0]
                    for sine in (limit * (1 - 1e-5), limit * (1 + 1e-4)))
    assert below == pytest.approx(above, rel=0, abs=1e-4 * limit + 1e-11)
