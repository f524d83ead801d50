"""Weights are whole numbers, of which one counts."""

import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights


def test_triangles_alone_count_nothing_else():
    assert (TRIANGLES_ALONE.triangle, TRIANGLES_ALONE.span, TRIANGLES_ALONE.pixel) == (1, 0, 0)


def test_wrong_weights_are_refused():
    with pytest.raises(InputError, match="Weight of a span must be at least 0, not -1"):
        WorkWeights(span=-1)
    with pytest.raises(InputError, match="Weights must not all be 0"):
        WorkWeights(triangle=0, span=0, pixel=0)
    with pytest.raises(TypeError, match="Pixel must be an int"):
        WorkWeights(pixel=0.5)
