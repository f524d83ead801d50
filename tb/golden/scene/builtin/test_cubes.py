"""The array of boxes is regular."""

import numpy as np
import pytest

from golden.scene.builtin.cubes import cubes
from tb.golden.scene.builtin.solids import is_closed, volume


def test_boxes_form_a_regular_array_of_closed_cubes():
    boxes = cubes().vertices[7:].reshape(512, 6, 4, 3)
    centres = boxes.mean(axis=(1, 2))
    np.testing.assert_allclose(np.unique(centres.round(9), axis=0),
                               np.stack(np.meshgrid(*[np.arange(8) + 0.5] * 3, indexing="ij"), -1).reshape(-1, 3))
    for box in boxes[::37]:
        assert is_closed(box)
        assert volume(box) == pytest.approx(0.125)
