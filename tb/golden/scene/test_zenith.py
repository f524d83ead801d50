"""Sky, sun, luminaires and patches of the sky follow the scene's up, whichever axis a file has for it."""

import warnings

import numpy as np
import pytest

from golden.base.errors import InputWarning
from golden.light.factors.sky_division import SkyDivision
from golden.scene.export import export_scene
from golden.scene.luminaires.luminaire import Luminaire
from golden.scene.material import Material
from golden.scene.open import open_scene
from golden.scene.sky.daylight import Daylight
from golden.scene.zenith import warn_of_upright_floors, zenith_line
from radiosity.tasks.render import View
from tb.golden.light.scenes import rectangle, scene_of
from tb.golden.scene.files import write
from tb.golden.scene.luminaires.texts import ies

Z_UP = np.eye(3)
# From a scene with z up to the same one with y up: east stays x, north becomes -z.
Y_UP = np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0)], dtype=float)
SQUARE = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
DIRECTIONS = np.random.default_rng(1).normal(size=(99, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def square_file(folder, name, turn):
    """A turned square as it lies: a writer turns no scene whose up is the format's."""
    if name.endswith("vs3"):
        return write(folder, name, "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nS 1 1 2 3 0 0 0 0.9 a\nEnd of data\n")
    up = (0, 1, 0) if name.endswith(("obj", "glb")) else (0, 0, 1)
    export_scene(scene_of(([SQUARE @ turn.T], Material(name="grey")), up=up), folder / name)
    return folder / name


def lights(folder, turn):
    """Sky, sun and a luminaire over the square."""
    path = write(folder, "a.ies", ies(size=(0.4, 1.6, 0)))
    return (Daylight(sky="cie-clear", sun=(130, 40)),
            Luminaire(path=path, turn=30, place=tuple((turn @ (0.2, 0.3, 2)).tolist())))


@pytest.mark.parametrize(("name", "turn", "zenith"), [
    ("a.obj", Y_UP, None), ("a.glb", Y_UP, None), ("a.ply", Z_UP, None), ("a.stl", Z_UP, None), ("a.vs3", Z_UP, None),
    ("a.obj", Z_UP, (0, 0, 2)), ("a.ply", Y_UP, (0, 1, 0)), ("a.vs3", Z_UP, (0, 0, 1))])
def test_all_light_from_above_turns_with_the_file(tmp_path, name, turn, zenith):
    truth = scene_of(([SQUARE], Material(name="grey")))
    for light in lights(tmp_path, Z_UP):
        truth = light.scene(truth, 100.0)
    daylight, luminaire = lights(tmp_path, turn)
    view = View(zenith=zenith, daylight=daylight, luminaires=(luminaire,))
    found = view.scene(str(square_file(tmp_path, name, turn)), 100.0)
    np.testing.assert_allclose(found.background.radiance(DIRECTIONS @ turn.T), truth.background.radiance(DIRECTIONS))
    np.testing.assert_allclose(found.lights[0].direction, turn @ truth.lights[0].direction, atol=1e-12)
    for light, expected in zip(found.lights[1:], truth.lights[1:], strict=True):
        np.testing.assert_allclose(light.position, turn @ expected.position, atol=1e-12)
        np.testing.assert_allclose(light.web.axes, expected.web.axes @ turn.T, atol=1e-12)
    np.testing.assert_array_equal(SkyDivision("reinhart", found.up).numbers(DIRECTIONS @ turn.T),
                                  SkyDivision("reinhart").numbers(DIRECTIONS))


def test_a_zenith_turns_what_is_exported(tmp_path):
    """A file whose up is z, read as such, stays as it is in a format with z up."""
    path = square_file(tmp_path, "a.obj", Z_UP)
    export_scene(open_scene(path, zenith=(0, 0, 1)), tmp_path / "b.stl")
    assert open_scene(tmp_path / "b.stl").bounds.tolist() == [[0, 0, 0], [1, 1, 0]]


@pytest.mark.parametrize(("spec", "is_given", "facing", "line"), [
    ("a.obj", False, None, "zenith +y, as OBJ files have it (--zenith)"),
    ("A.GLB", False, None, "zenith +y, as GLB files have it (--zenith)"),
    ("a.gltf", False, None, "zenith +y, as glTF files have it (--zenith)"),
    ("a.nff", False, None, "zenith +y, as the view of NFF files has it (--zenith)"),
    ("cornell", False, None, "zenith +y, that of the scene (--zenith)"),
    ("a.obj", True, [(0, 0, 1)], "zenith +y, as given"),
    ("a.obj", False, [(0, 0, 1)] * 2,
     "zenith +y, as OBJ files have it (--zenith); all sensors face +z, which is level"),
    ("a.obj", False, [(0, 0, 1), (0, 1, 0)], "zenith +y, as OBJ files have it (--zenith)"),
    ("a.obj", False, [(0, 1, 0)], "zenith +y, as OBJ files have it (--zenith)")])
def test_the_report_says_which_direction_is_up_and_why(spec, is_given, facing, line):
    scene = scene_of(([SQUARE], Material(name="grey")), up=(0, 1, 0))
    assert zenith_line(spec, scene, is_given=is_given, facing=facing and np.array(facing, dtype=float)) == line


def test_a_direction_along_no_axis_is_named_by_its_numbers():
    scene = scene_of(([SQUARE], Material(name="grey")), up=(0, -0.25, 3))
    assert zenith_line("a.obj", scene, is_given=True) == "zenith 0,-0.25,3, as given"


def room(*names):
    """A square for each name: level with z up, upright, or sloped."""
    along = {"level": (0, 1, 0), "upright": (0, 0, 1), "sloped": (0, 1, 0.9)}
    return scene_of(*(([rectangle((0, 0, 0), (1, 0, 0), along[kind])], Material(name=name))
                      for kind, name in (name.split(":") for name in names)), up=(0, 1, 0))


@pytest.mark.parametrize(("names", "is_warned"), [
    (("level:Oak_Floor.001", "level:ceiling", "upright:wall"), True), (("level:Decke",), True),
    (("upright:floor", "level:wall"), False), (("level:floor", "upright:ceiling"), False),
    (("level:flooring shop", "upright:wall"), False), (("sloped:ground",), False), (("level:wall",), False)])
def test_floors_that_all_stand_upright_are_named(names, is_warned):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_upright_floors(room(*names))
    assert [(one.category, str(one.message)) for one in caught] == [(InputWarning, (
        "scene 'test': with the zenith +y all surfaces named like floors or ceilings stand upright; they are level "
        "with --zenith 0,0,1"))] * is_warned


def test_only_a_zenith_that_nobody_gave_is_doubted(tmp_path):
    write(tmp_path, "a.mtl", "newmtl floor\nKd 0.5 0.5 0.5\n")
    path = write(tmp_path, "a.obj", "mtllib a.mtl\nusemtl floor\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    with pytest.warns(InputWarning, match="--zenith 0,0,1"):
        View().scene(str(path), 100.0)
    # A warning would be an error.
    View(zenith=(0, 1, 0)).scene(str(path), 100.0)
