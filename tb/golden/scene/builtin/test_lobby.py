"""The hall is large, closed and of few patches."""

import numpy as np
import pytest

from golden.scene.builtin.lobby import HEIGHT, LENGTH, WIDTH, lobby
from tb.golden.scene.builtin.solids import components, is_closed, volume


def test_shell_holds_the_hall_and_its_window_recesses():
    (shell,) = [part for part in components(lobby().vertices) if is_closed(part) and volume(part) < 0]
    recess = (4.0 - 1.8) * (HEIGHT - 1.8) * 0.25
    assert volume(shell) == pytest.approx(-(LENGTH * WIDTH * HEIGHT + 4 * recess))


def test_light_falls_from_the_ceiling_and_through_windows():
    scene = lobby()
    lights = scene.normals[scene.channels("emission").max(axis=1) > 0]
    directions, counts = np.unique(lights.round(12) + 0.0, axis=0, return_counts=True)
    assert dict(zip(map(tuple, directions.tolist()), counts.tolist(), strict=True)) == {(0, 0, -1): 8, (0, -1, 0): 4}
