import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.camera import LARGEST, Camera


@pytest.mark.parametrize(("given", "says"), [
    ({"eye": (1e300, 0, 0)}, "Eye must be three finite coordinates up to 1e+30"),
    ({"target": (0, np.inf, 0)}, "Target must be three finite coordinates"),
    ({"up": (0, 0, np.nan)}, "Up must be three finite coordinates"),
    ({"eye": (0, 0)}, "Eye must be three finite coordinates"),
    ({"target": (0, 0, 0)}, "Target must be away from the eye"),
    ({"up": (2, 0, 0)}, "Up must not be zero or along the view"),
    ({"fov": 180.0}, "Field of view must be between 0 and 180 degrees"),
])
def test_a_camera_that_is_none_is_refused(given, says):
    with pytest.raises(InputError, match=says.replace("+", r"\+")):
        Camera(**{"eye": (0, 0, 0), "target": (1, 0, 0)} | given)


def test_axes_are_finite_however_far_the_eye_is():
    axes = Camera(eye=(LARGEST, 0, 0), target=(-LARGEST, 0, 0)).axes
    assert axes == pytest.approx(np.array([(0, 1, 0), (0, 0, 1), (-1, 0, 0)]))
