import numpy as np
import pytest

from golden.light.light_weights import BLUR, HORIZON, light_weights

LIGHT = np.array([[(-1, 1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 2.0)]])
"""A square that shines down."""


def weights(position, normal=(0, 0, 1), *, vertices=LIGHT, two_sided=(False,), power=(3.0,), front=(0, 0, -1.0)):
    centre = vertices.mean(axis=1)
    radius2 = ((vertices - centre[:, None]) ** 2).sum(axis=2).max(axis=1)
    return light_weights(np.array([position], dtype=float), np.array([normal], dtype=float), vertices, centre,
                         np.array([front]), np.array(two_sided), np.array(power), radius2)[0]


def test_the_weight_is_power_times_the_highest_sine_and_the_lights_cosine_over_the_squared_distance():
    assert weights((0, 0, 0)) == pytest.approx(3 * 1 / (4 + 2))
    # A corner is higher than the centre.
    corners = (LIGHT[0] - [1, -1, 0]) @ np.array([0, 0.6, 0.8]) / np.linalg.norm(LIGHT[0] - [1, -1, 0], axis=1)
    assert corners.max() > np.array([-1, 1, 2]) @ [0, 0.6, 0.8] / np.sqrt(6)
    cosine = (2 + BLUR * np.sqrt(2)) / np.sqrt(6)
    assert weights((1, -1, 0), (0, 0.6, 0.8)) == pytest.approx(3 * corners.max() * cosine / (1 + 1 + 4 + 2))


def test_a_light_seen_aslant_has_little_weight_and_a_near_one_much():
    """Beside a lamp's plane, far away and right at its rim, where it fills up to a half of what a point sees."""
    far, near = (weights((x, 0, 2 - 1e-9), (-0.8, 0, 0.6)) * ((x * x + 2) / 3 / 0.8) for x in (100, 1.001))
    assert far == pytest.approx(BLUR * np.sqrt(2) / 100, rel=0.02)
    assert near > BLUR


@pytest.mark.parametrize(("position", "normal", "two_sided", "lit"), [
    ((0, 0, 0), (0, 0, 1), False, True), ((0, 0, 4), (0, 0, -1), False, False), ((0, 0, 4), (0, 0, -1), True, True),
    ((0, 0, 0), (0, 0, -1), True, False), ((5, 0, 1), (-1, 0, 0), False, True), ((5, 0, 2), (0, 0, 1), True, False),
    # One corner of four is above the horizon.
    ((0, 0, 0), tuple(np.array([0.9, 0.9, -0.8]) / np.linalg.norm([0.9, 0.9, -0.8])), False, True)])
def test_only_lights_that_may_be_seen_have_a_weight(position, normal, two_sided, lit):
    assert (weights(position, normal, two_sided=(two_sided,)) > 0).all() == lit


def test_a_light_in_the_plane_of_a_point_has_none():
    tilt = np.array([0, HORIZON / 10, 1.0])
    assert not weights((0, 0, 2), tilt / np.linalg.norm(tilt), two_sided=(True,)).any()


def test_a_point_on_a_corner_of_a_light_has_a_finite_weight():
    assert np.isfinite(weights((1, 1, 2), two_sided=(True,))).all()


def on_arrays(position, normal, vertices, centre, front, two_sided, power, radius2):
    """The same by the rule's own words, a corner of all lights at a time."""
    highest = np.zeros((len(position), len(vertices)))
    for corner in [*np.moveaxis(vertices, 1, 0), centre]:
        toward = corner - position[:, None]
        length = np.maximum(np.sqrt(np.einsum("mlj,mlj->ml", toward, toward)), 1e-300)
        highest = np.maximum(highest, np.einsum("mlj,mj->ml", toward, normal) / length)
    facing = -np.einsum("mlj,lj->ml", toward, front)
    seen = (highest >= HORIZON) & ((facing > 0) | two_sided)
    cosine = np.minimum(1, (np.abs(facing) + BLUR * np.sqrt(radius2)) / length)
    return seen * highest * cosine * power / (length**2 + radius2)


def test_arrays_give_what_compiled_loops_give():
    """Points and lights on a grid, many in one plane: points at corners and behind edges, lights seen edge-on."""
    random = np.random.default_rng(3)
    vertices, position = (random.integers(-1, 2, size).astype(float) for size in ((9, 4, 3), (50, 3)))
    normal, front = (np.concatenate([np.eye(3), -np.eye(3)])[random.integers(6, size=count)] for count in (50, 9))
    centre = vertices[:, 0]
    arguments = (position, normal, vertices, centre, front, random.random(9) < 0.5, random.random(9), random.random(9))
    assert (((centre - position[:, None]) * front).sum(axis=2) == 0).mean() > 0.1
    compiled = light_weights(*arguments)
    assert 0.1 < (compiled > 0).mean() < 0.9
    assert on_arrays(*arguments) == pytest.approx(compiled, rel=1e-12)
