"""A file is read the same in whatever dialect of its format a program writes it, without a warning."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.scene.lights import DirectionalLight
from golden.scene.load import load_scene
from tb.golden.scene.dialects import DAMAGES, DIALECTS, damaged
from tb.golden.scene.files import refusal
from tb.lib.schedules import SETTINGS

MANY = pytest.param(500, marks=pytest.mark.nightly)


def faces(scene):
    """By a patch's corners its grey and whether it is two-sided."""
    assert (scene.channels("diffuse") == scene.channels("diffuse")[:, :1]).all()
    greys = [round(grey, 9) for grey in scene.channels("diffuse")[:, 0].tolist()]
    return {frozenset(map(tuple, patch)): both for patch, *both in zip(
        scene.vertices.tolist(), greys, scene.two_sided.tolist(), strict=True)}


def lights(scene):
    """Kind, strength and the angles of a cone of each light."""
    return tuple(("directional", light.irradiance, ()) if isinstance(light, DirectionalLight)
                 else ("spot" if light.cone else "point", light.intensity,
                       () if light.cone is None else (round(light.cone.inner, 4), round(light.cone.outer, 4)))
                 for light in scene.lights)


@pytest.mark.parametrize("examples", [40, MANY])
@pytest.mark.parametrize("name", DIALECTS)
def test_a_file_says_the_same_in_every_dialect(tmp_path, name, examples):
    @settings(SETTINGS, max_examples=examples)
    @given(file=DIALECTS[name])
    def reads(file):
        for part, data in file.files.items():
            (tmp_path / part).write_bytes(data)
        scene = load_scene(tmp_path / next(iter(file.files)))
        assert faces(scene) == {corners: list(values) for corners, values in file.faces.items()}
        assert lights(scene) == file.lights
        assert (scene.textures is not None) == bool(file.uv)
        for patch, mapping in zip(scene.vertices.tolist(), [] if scene.textures is None else scene.textures.mapping,
                                  strict=scene.textures is not None):
            assert {corner: tuple(np.round(mapping @ [*corner, 1], 6)) for corner in map(tuple, patch)}.items() \
                <= file.uv.items()
    reads()


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("examples", [40, MANY])
@pytest.mark.parametrize("name", DIALECTS)
def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path, name, examples):
    @settings(SETTINGS, max_examples=examples)
    @given(file=DIALECTS[name], number=st.integers(0, 2), damage=DAMAGES)
    def refuses(file, number, damage):
        parts = dict(file.files)
        which = list(parts)[number % len(parts)]
        parts[which] = damaged(parts[which], damage)
        for part, data in parts.items():
            (tmp_path / part).write_bytes(data)
        path = tmp_path / next(iter(parts))
        message = refusal(path)
        assert message is None or (message.startswith(str(path)) and "\n" not in message)
    refuses()
