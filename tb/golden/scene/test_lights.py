from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.load import load_scene
from golden.scene.material import Material
from golden.scene.sky.daylight import Daylight
from tb.golden.scene.files import gltf


def test_a_spot_has_the_angles_of_gltf_unless_it_states_others(tmp_path):
    nodes = [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    extensions = {"KHR_lights_punctual": {"lights": [{"type": "spot"}]}}
    (spot,) = load_scene(gltf(tmp_path, nodes=nodes, extensions=extensions)).lights
    assert (spot.cone.inner, spot.cone.outer) == pytest.approx((0, 45))


@pytest.mark.parametrize(("inner", "outer"), [(0, 45), (0, 90), (20, 40), (60, 90), (89, 90), (0, 1), (30, 30.01)])
def test_a_cone_is_whole_up_to_its_inner_angle_and_dark_from_its_outer_one(inner, outer):
    """At both angles exactly, at the axis and behind the light, for a tilted direction of any length."""
    cone = Cone(direction=(2, -1, 2), inner=inner, outer=outer)
    axis, across = np.array((2.0, -1, 2)) / 3, np.array((1.0, 2, 0)) / np.sqrt(5)

    def factor(*angles):
        angles = np.radians(angles)[:, None]
        return cone.factor(-7 * (np.cos(angles) * axis + np.sin(angles) * across))

    whole, dark = np.cos(np.radians((inner, outer)))
    # The extension bounds the sharpness of the edge: a narrow cone never has its whole intensity.
    least = max(whole - dark, 1e-3)
    between = np.cos(np.radians((inner + outer) / 2))
    expected = [min(1, (cosine - dark) / least) ** 2 for cosine in (1, whole, between, dark)]
    assert factor(0, inner, (inner + outer) / 2, outer) == pytest.approx(expected, abs=1e-9)
    assert factor(outer + 0.01, 90.01, 135, 180).tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize(("make", "says"), [
    (lambda: Cone(direction=(0, 0, 0)), "Direction must not be zero"),
    (lambda: Cone(direction=(0, 0, 1), inner=51, outer=50), "Angles must be 0 to 90 degrees"),
    (lambda: Cone(direction=(0, 0, 1), outer=91), "Angles must be 0 to 90 degrees"),
    (lambda: DirectionalLight(direction=(0, 0, float("nan")), irradiance=(1, 1, 1)), "Direction must be three finite"),
    (lambda: DirectionalLight(direction=(0, 0, 1), irradiance=(1, -1, 1)), "Irradiance must be at least 0"),
    (lambda: PointLight(position=(0, 0, 1), intensity=(1, -1, 1)), "Intensity must be at least 0"),
    (lambda: PointLight(position=(0, 0, 1), intensity=(1, 1e300, 1)), "Intensity must be at least 0 and at most"),
    (lambda: Material(name="lamp", emission=(1, 1e300, 1)), "material 'lamp': Emission must be at most 1e.30"),
    (lambda: replace(builtin_scene("furnace:1"), background=(0, 0, 1e300)), "Background must be at least 0"),
    (lambda: Daylight(sky_illuminance=1e300), "Sky illuminance must be at least 0 and at most 1e.30"),
    (lambda: PointLight(position=(0, 1), intensity=(1, 1, 1)), "Position must be three finite"),
])
def test_a_light_that_is_none_is_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()
