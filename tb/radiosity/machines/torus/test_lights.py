"""Rays that leave space are tested with the lights."""

import numpy as np
import pytest

from radiosity.machines.torus.torus_run import TorusSetup, simulate_torus
from radiosity.machines.torus.torus_scene import TorusScene
from radiosity.machines.torus.torus_turns import SCALE

pytestmark = pytest.mark.usefixtures("interpreted")


def test_a_light_is_seen_by_the_rays_that_leave_space():
    corners = np.array([[(1.4, 1.4, 5), (1.6, 1.4, 5), (1.6, 1.6, 5), (1.4, 1.6, 5)]], dtype=float)
    scene = TorusScene(name="light", corners=corners, counts=np.array([4]), coefficients=np.zeros((1, 13)),
                       lights=np.array([[0, 0, 3, 0.3, 0.25, 0.5, 1.0]]), slope=0.35)
    found = simulate_torus(scene, TorusSetup(nodes=4, size=(16, 16), subdivisions=3))
    at = ((2 * np.arange(16) + 1) / 16 - 1) * 0.35
    # The light of radius 0.3 at a distance of 3 fills a cone whose sine is 0.1.
    square = at[:, None] ** 2 + at ** 2
    is_lit = square / (1 + square) < 0.01
    assert is_lit.any()
    assert (found.sums == is_lit[:, :, None] * np.array([SCALE // 4, SCALE // 2, SCALE])).all()
