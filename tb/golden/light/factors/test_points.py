import numpy as np
import pytest
from scipy.stats import qmc

from golden.cast.frame import frame
from golden.light.factors import points
from golden.light.factors.points import REPLICATES
from golden.light.sampling import mix, uniform
from tb.golden.light.factors.on_arrays import on_arrays

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
KITE = np.array([(0, 0, 1), (3, 0, 1), (2, 2, 1), (0, 1, 1)], dtype=float)
TRIANGLE = np.array([(0, 0, 0), (2, 0, 0), (0, 3, 0), (0, 3, 0)], dtype=float)
# No axis is one of the plane.
TURN = frame(np.array([0.48, 0.6, 0.64]))
CENTROIDS = {"square": (SQUARE, (0.5, 0.5, 0)), "kite": (KITE, (17 / 12, 3 / 4, 1)),
             "triangle": (TRIANGLE, (2 / 3, 1, 0)),
             "tilted kite": (KITE @ TURN, (17 / 12, 3 / 4, 1) @ TURN)}


@pytest.fixture(autouse=True)
def _on_arrays(monkeypatch):
    on_arrays(monkeypatch, points)


def sequence(uses, number):
    return np.stack(points.sequence(uses, number), axis=-1)


def columns(patch, count):
    """One patch for each of the points, the points last."""
    return np.repeat(patch[..., None], count, axis=-1)


def area(patch):
    return np.linalg.norm(np.cross(patch[2] - patch[0], patch[3] - patch[1])) / 2


def drawn(patch, count=1 << 14):
    point = sequence(np.full(count, mix(1, 2)), np.arange(count))
    return columns(patch, count), np.full(count, (patch[2] == patch[3]).all()), *point[:, :2].T


@pytest.mark.parametrize(("patch", "centroid"), CENTROIDS.values(), ids=CENTROIDS)
def test_points_are_uniform_by_area(patch, centroid):
    found = np.stack(points.point_on(*drawn(patch)), axis=1)
    np.testing.assert_allclose(found.mean(axis=0), centroid, rtol=0, atol=3e-3)
    inward = np.cross(patch[2] - patch[0], patch[3] - patch[1])
    turns = np.cross(np.roll(patch, -1, axis=0) - patch, found[:, None] - patch) @ inward
    assert turns.min() >= -1e-12


@pytest.mark.parametrize(("patch", "centroid"), CENTROIDS.values(), ids=CENTROIDS)
def test_area_vectors_weigh_the_points(patch, centroid):
    found, vectors = np.split(np.stack(points.weighted_point_on(*drawn(patch)), axis=1), 2, axis=1)
    weights = np.linalg.norm(vectors, axis=1)
    assert weights.mean() == pytest.approx(area(patch), rel=2e-4)
    np.testing.assert_allclose(weights @ found / weights.sum(), centroid, rtol=0, atol=3e-3)
    inward = np.cross(patch[2] - patch[0], patch[3] - patch[1])
    np.testing.assert_allclose(np.cross(vectors, inward), 0, rtol=0, atol=1e-11)
    assert (vectors @ inward).min() > 0


def test_points_of_a_triangle_have_equal_weights():
    weights = np.linalg.norm(points.weighted_point_on(*drawn(TRIANGLE, 64))[3:], axis=0)
    np.testing.assert_allclose(weights, area(TRIANGLE), rtol=1e-9)


def test_directions_are_distributed_by_the_cosine():
    normal = np.array([0.6, 0, 0.8])
    count = 1 << 14
    point = sequence(np.full(count, mix(3)), np.arange(count))
    directions = np.stack(points.cosine_direction(columns(frame(normal), count), *point[:, 2:].T), axis=1)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-12)
    cosine = directions @ normal
    assert cosine.min() >= 0
    # The moments of 2 cos d(cos).
    assert cosine.mean() == pytest.approx(2 / 3, abs=1e-3)
    assert (cosine**2).mean() == pytest.approx(1 / 2, abs=1e-3)


def test_the_sequence_begins_with_the_hashes_of_all_sampling():
    number = np.arange(REPLICATES)
    use = mix(9, np.full(REPLICATES, 4))
    for dimension, found in enumerate(sequence(use, number).T):
        np.testing.assert_array_equal(found, uniform(mix(use, number), dimension))


def test_the_sequence_is_more_even_than_random_points_in_every_replicate():
    count = 256 * REPLICATES
    number = np.arange(count)
    point = sequence(np.full(count, mix(5)), number)
    box = (point < 0.49).all(axis=1)
    shares = np.bincount(number % REPLICATES, box, REPLICATES) / 256
    # Random points would miss 0.058 by sqrt(0.058 0.942) / 16 = 0.015.
    assert np.sqrt(((shares - 0.49**4)**2).mean()) < 0.008
    assert len(np.unique(shares)) > 1


def test_without_its_shifts_it_is_the_sequence_of_sobol():
    number = REPLICATES * np.arange(1 << 10)
    use = np.full(len(number), mix(4))
    shift = (sequence(use[:1], number[:1]) * 2.0**53).astype(np.uint64)
    found = ((sequence(use, number) * 2.0**53).astype(np.uint64) ^ shift) * 2.0**-53
    # That of scipy is in the order of Gray's code.
    gray = np.arange(len(number)) ^ np.arange(len(number)) >> 1
    expected = qmc.Sobol(4, scramble=False).random(len(number))
    np.testing.assert_array_equal(found[gray][:, [2, 3, 0, 1]], expected)


def test_numbers_of_a_use_do_not_depend_on_others():
    uses = mix(7, np.arange(5))
    alone = sequence(uses[3:4], np.array([40]))
    np.testing.assert_array_equal(sequence(uses, np.full(5, 40))[3], alone[0])
