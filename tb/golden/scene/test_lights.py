from dataclasses import replace

import numpy as np
import pytest

from golden.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.load import load_scene
from golden.scene.material import Material
from golden.scene.sky.daylight import Daylight
from tb.golden.scene.test_load import gltf

HALF = 0.5**0.5


def lights_of(folder, *lights):
    """The lights of a file whose nodes look down: -z turned to -y."""
    nodes = [{"mesh": 0, "children": list(range(1, 1 + len(lights)))},
             *({"translation": [1, 2, 3], "rotation": [-HALF, 0, 0, HALF],
                "extensions": {"KHR_lights_punctual": {"light": number}}} for number in range(len(lights)))]
    return load_scene(gltf(folder, nodes=nodes, extensions={"KHR_lights_punctual": {"lights": list(lights)}})).lights


def test_spot_and_directional_lights_of_gltf_are_read(tmp_path):
    spot, sun = lights_of(tmp_path, {"type": "spot", "intensity": 8, "color": [1, 0.5, 0],
                                     "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}},
                          {"type": "directional", "intensity": 3})
    assert (spot.position, spot.intensity) == ((1, 2, 3), (8, 4, 0))
    assert spot.cone.direction == pytest.approx((0, -1, 0))
    assert (spot.cone.inner, spot.cone.outer) == pytest.approx(np.degrees((0.2, 0.5)))
    assert sun.direction == pytest.approx((0, -1, 0))
    assert sun.irradiance == (3, 3, 3)


def test_a_spot_has_the_angles_of_gltf_unless_it_states_others(tmp_path):
    (spot,) = lights_of(tmp_path, {"type": "spot"})
    assert (spot.cone.inner, spot.cone.outer) == pytest.approx((0, 45))


def test_a_cone_falls_off_as_the_extension_says():
    cone = Cone(direction=(0, 0, -2), inner=20, outer=40)
    angles = np.radians([0, 19.9, 30, 40.1, 120])
    toward = 3 * np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
    inner, middle, outer = np.cos(np.radians((20, 30, 40)))
    assert cone.factor(toward) == pytest.approx([1, 1, ((middle - outer) / (inner - outer)) ** 2, 0, 0])


@pytest.mark.parametrize(("make", "says"), [
    (lambda: Cone(direction=(0, 0, 0)), "Direction must not be zero"),
    (lambda: Cone(direction=(0, 0, 1), inner=50, outer=50), "Angles must be 0 to 90 degrees"),
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
