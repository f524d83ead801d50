import warnings
from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError, InputWarning
from golden.cast.naive import Naive
from golden.light.direct import DirectLight
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.lights import PointLight
from golden.scene.luminaires.luminaire import Luminaire
from radiosity.tasks import render
from radiosity.tasks.render import View
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.golden.scene.files import write
from tb.golden.scene.luminaires.texts import eulumdat, ies

FLOOR = rectangle((-9, -9, 0), (18, 0, 0), (0, 18, 0))
GAMMA = np.arange(0, 91, 1.0)
LAMBERTIAN = 1000 * np.cos(np.radians(GAMMA))


def hung(folder, text, *, name="a.ies", place=(0, 0, 2), turn=0.0, up=(0, 0, 1)):
    path = folder / name
    path.write_text(text, encoding="latin-1")
    return Luminaire(path=path, place=place, turn=turn).scene(scene_of((FLOOR, BLACK), up=up), 100.0)


def lux(scene, *places):
    points = SurfacePoints(np.array(places, dtype=float), np.tile((0.0, 0, 1), (len(places), 1)),
                           np.zeros(len(places), dtype=int))
    arriving = DirectLight(scene, Naive(scene), Tally(), 1).irradiance(points, mix(1, np.arange(len(places))))
    return 100 * np.pi * arriving[:, 1]


@pytest.mark.parametrize(("name", "text"), [
    ("a.ies", ies(vertical=GAMMA, candela=[LAMBERTIAN])),
    ("a.LDT", eulumdat(gamma=GAMMA, candela=[LAMBERTIAN / 4], flux=4000))])
def test_a_lambertian_point_lights_a_floor_as_its_closed_form(tmp_path, name, text):
    scene = hung(tmp_path, text, name=name)
    distance = np.array([0.0, 0.7, 2, 5])
    found = lux(scene, *((x, 0, 0) for x in distance))
    np.testing.assert_allclose(found, 1000 * 2**2 / (distance**2 + 4) ** 2, rtol=1e-3)


def test_an_opening_shares_its_light_among_points(tmp_path):
    """As a square lamp of the same intensity does: 1000 cd/m2 of 1 m2, seen from 2 m below, has 230.84 lx."""
    scene = hung(tmp_path, ies(vertical=GAMMA, candela=[LAMBERTIAN], size=(1, 1, 0)))
    assert len(scene.lights) == 16
    assert lux(scene, (0, 0, 0)) == pytest.approx(230.84, rel=0.01)


@pytest.mark.parametrize(("name", "text"), [
    ("a.ies", ies(vertical=GAMMA, candela=[LAMBERTIAN], size=(-1, -1, 0))),
    ("a.ies", ies(vertical=GAMMA, candela=[LAMBERTIAN], size=(-1, 0, 0)).replace("IESNA:LM-63-2002", "IESNA91")),
    ("a.ldt", eulumdat(gamma=GAMMA, candela=[LAMBERTIAN], size=(1000, 0)))])
def test_a_round_opening_lights_as_a_disk(tmp_path, name, text):
    """The light of 1000 cd from a disk of radius R, h above a floor, is 1000 / (R^2 + h^2) below its middle.

    A square of the same width has 230.84 lx. The mean square of the points' distances is that of a disk, R^2 / 2.
    """
    scene = hung(tmp_path, text, name=name)
    assert lux(scene, (0, 0, 0)) == pytest.approx(1000 / (0.5**2 + 2**2), rel=1e-3)
    places = np.array([light.position[:2] for light in scene.lights])
    np.testing.assert_allclose(places.T @ places / len(places), np.eye(2) * 0.5**2 / 4, atol=1e-12)


def test_points_are_in_the_middles_of_equal_parts_of_an_opening_that_is_longer_than_wide(tmp_path):
    """C0 is along the length; its file has the width first."""
    scene = hung(tmp_path, ies(vertical=GAMMA, candela=[LAMBERTIAN], size=(0.4, 1.6, 0)))
    middles = np.array((-0.375, -0.125, 0.125, 0.375))
    found = sorted(light.position for light in scene.lights)
    np.testing.assert_allclose(found, [(1.6 * x, 0.4 * y, 2) for x in middles for y in middles], atol=1e-12)


@pytest.mark.parametrize(("turn", "bright"), [(0, (1, 0, 0)), (90, (0, 1, 0)), (180, (-1, 0, 0))])
def test_c0_is_along_x_and_turns_counter_clockwise(tmp_path, turn, bright):
    values = np.zeros((4, 3))
    values[[0, 3]] = 100
    scene = hung(tmp_path, ies(horizontal=(0, 80, 280, 360), candela=values), turn=turn)
    found = lux(scene, (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0))
    np.testing.assert_array_equal(found > 1, [(place == np.array(bright)).all() for place in (
        (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0))])


@pytest.mark.parametrize("scale", [1, 1000])
def test_a_scene_that_seems_to_be_in_millimetres_is_named(tmp_path, scale):
    write(tmp_path, "room.obj", f"v 0 0 0\nv {4 * scale} 0 0\nv 0 0 {4 * scale}\nf 1 2 3\n")
    write(tmp_path, "a.ies", ies())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        View(luminaires=(Luminaire(path=tmp_path / "a.ies", place=(1, 1, 1)),) * 2).scene(tmp_path / "room.obj", 1.0)
    assert [str(warning.message) for warning in caught] == ([] if scale == 1 else [
        "scene 'room': it is 4000 long, and a length counts as a metre for luminaires; in another unit they are too "
        "dark"])


def test_a_file_s_point_lights_in_millimetres_are_named(monkeypatch):
    """An area that emits, and a sky, give the same light in any unit."""
    opened = scene_of((rectangle((0, 0, 0), (4000, 0, 0), (0, 4000, 0)), BLACK))
    lit = replace(opened, lights=(PointLight(position=(1, 1, 1), intensity=(1.0, 1, 1)),))
    for scene, expected in ((opened, 0), (lit, 1)):
        monkeypatch.setattr(render, "open_scene", lambda name, scene=scene, **_: scene)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            View().scene("room", 1.0)
        assert ["a metre for its point lights" in str(warning.message) for warning in caught] == [True] * expected


def test_a_luminaire_without_light_is_named(tmp_path):
    with pytest.warns(InputWarning) as caught:
        hung(tmp_path, ies(multiplier=0))
    assert [str(warning.message) for warning in caught] == [f"{tmp_path / 'a.ies'}: it emits no light"]


@pytest.mark.parametrize(("name", "text", "message"), [
    ("a.txt", "", "Suffix must be .ies or .ldt, not '.txt'"), ("a.ies", "", "it has no line TILT="),
    ("a.ies", ies(vertical=(0, 90, 45)), "Vertical angles must ascend"),
    ("a.ldt", "\0\1\2", "the file ends before")])
def test_bad_files_are_one_line_with_their_path(tmp_path, name, text, message):
    with pytest.raises(InputError) as caught:
        hung(tmp_path, text, name=name)
    assert str(caught.value).startswith(f"{tmp_path / name}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_no_file_is_refused(tmp_path):
    for path in (tmp_path / "nothing.ies", tmp_path):
        with pytest.raises(InputError, match=r"cannot be read|Suffix must"):
            Luminaire(path=path, place=(0, 0, 0)).scene(scene_of((FLOOR, BLACK)), 100.0)
    with pytest.raises(InputError, match="Place and turn must be finite"):
        Luminaire(path=tmp_path, place=(0, 0, np.nan))
