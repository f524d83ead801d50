import numpy as np
import pytest
from PIL import Image

from golden.scene.luminaires.luminaire import Luminaire
from golden.scene.sky.daylight import SKIES, Daylight
from golden.scene.texture import Texture
from radiosity.workers.parcel import Parcel
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.golden.scene.files import write
from tb.golden.scene.luminaires.texts import ies

SCENE = scene_of((rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), BLACK))
DIRECTIONS = np.random.default_rng(3).normal(size=(50, 3))


class Shared:
    """Something that both ends have, and that cannot be pickled."""

    def __reduce__(self):
        raise AssertionError("it must not be pickled")


def test_a_copy_refers_to_what_its_process_knows():
    here, there = Shared(), Shared()
    parcel = Parcel.of({"table": np.arange(3), "scene": here, "again": [here]}, {"scene": here})
    copy = parcel.open({"scene": there})
    assert copy["table"].tolist() == [0, 1, 2]
    assert copy["scene"] is copy["again"][0] is there


def test_parcels_are_known_by_their_content():
    first, same, other = (Parcel.of(np.full(9, value), {}) for value in (1, 1, 2))
    assert first == same
    assert hash(first) == hash(same)
    assert first != other
    assert "content" not in repr(first)


def copied(scene):
    return Parcel.of(scene, {}).open({})


@pytest.mark.parametrize("sky", SKIES)
def test_a_scene_has_its_daylight_at_a_worker(sky):
    scene = Daylight(sky=sky, sun=(120, 40), sun_illuminance=1000.0,
                     weather=(500.0, 100.0) if sky == "perez" else None).scene(SCENE, 100.0)
    copy = copied(scene)
    assert copy.lights == scene.lights != ()
    assert copy.background.radiance(DIRECTIONS).tobytes() == scene.background.radiance(DIRECTIONS).tobytes()


def test_a_scene_has_its_luminaires_at_a_worker(tmp_path):
    path = write(tmp_path, "a.ies", ies(candela=[[100, 50, 7]]))
    scene = Luminaire(path=path, place=(0.0, 0.0, 1.0)).scene(SCENE, 100.0)
    (light,), (copy,) = scene.lights, copied(scene).lights
    assert copy.intensity == light.intensity
    assert copy.web.factor(DIRECTIONS).tobytes() == light.web.factor(DIRECTIONS).tobytes()


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
def test_a_picture_has_its_colours_at_a_worker(wrap):
    pixels = np.random.default_rng(4).integers(0, 256, (5, 3, 3)).astype(np.uint8)
    texture = Texture(Image.fromarray(pixels), wrap=(wrap, wrap))
    assert copied(texture).at(DIRECTIONS[:, :2]).tobytes() == texture.at(DIRECTIONS[:, :2]).tobytes()
