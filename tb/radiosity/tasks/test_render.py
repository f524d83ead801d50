"""Every option of a render reaches its file: all values differ from each other and from the defaults."""

import json
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from golden.base.errors import InputError, InputWarning
from golden.light.image import false_colour, write_png
from golden.light.photometry import surface_file
from golden.light.photometry.sensors import Sensors
from golden.light.tone import tone_map
from golden.render.two_pass import RenderResult, RenderSettings
from golden.scene.lights import PointLight
from golden.scene.material import Material
from radiosity.tasks import photometry, render
from radiosity.tasks.photometry import Photometry
from radiosity.tasks.render import RenderFiles, View, render_scene
from tb.golden.light.exr import read_exr
from tb.golden.light.scenes import rectangle, scene_of

SHAPE = 9, 14
EFFICACY = 90.0
random = np.random.default_rng(1)
IMAGE = random.random((*SHAPE, 3)) * np.array([1, 2, 0.5])
IMAGE[4, 5] = 1000, 2000, 500
TESTS, STEPS = random.integers(0, 99, (2, *SHAPE))
RECEIVED = random.random(SHAPE) * 3
RECEIVED[2, 3] = 700
MEASURED = np.array([(1, 2, 3), (4, 6, 5), (9, 7, 8)], dtype=float)
RAYS = {kind: {"rays": rays, "hits": 1, "tests": 2, "steps": 3} for kind, rays in (
    ("primary", 50), ("hemisphere", 30), ("shadow", 120))}
STATS = {"scene": "test", "patches": 1, "elements": 1, "nodes": 4, "rays": RAYS, "total": RAYS["shadow"],
         "settings": {"width": 1, "height": 1, "solver": "proximity", "method": "grid"},
         "solver": {"steps": 1, "converged": True}, "seconds": {}, "not_computed": [], "noise": None}
LIT = scene_of((rectangle((0, 0, 0), (1000, 0, 0), (0, 1, 0)), Material(name="lamp", emission=(1, 1, 1))))
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@pytest.fixture(autouse=True)
def rendered(monkeypatch):
    """The options of the last render, whose result is made up."""
    given = {}

    def remember(scene, **options):
        given.update(options, scene=scene)
        return RenderResult(image=IMAGE, tests=TESTS, steps=STEPS, received=RECEIVED, sensors=MEASURED,
                            indirect="light", stats=STATS)

    monkeypatch.setattr(render, "open_scene", lambda name, zenith: replace(LIT, up=zenith or LIT.up))
    monkeypatch.setattr(render, "render", remember)
    return given


def picture(path):
    with Image.open(path) as image:
        return np.asarray(image)


def written(files, view=None, *, caster=None, **options):
    return render_scene("lit", view or View(), RenderSettings(), files, method="other",
                        caster=lambda scene: nullcontext(caster), **options)


@pytest.mark.parametrize("options", [
    {}, {"exposure": 3.0}, {"exposure": 3.0, "tone": "linear"}, {"exposure": 3.0, "gamma": 1.3}, {"bits": 16}])
def test_pictures_are_as_bright_as_the_options_say(options, tmp_path):
    written(RenderFiles(images=(tmp_path / "a.png", tmp_path / "a.exr"), photometry=Photometry(efficacy=EFFICACY),
                        **options))
    expected = tone_map(IMAGE, exposure=options.get("exposure"), curve=options.get("tone", "reinhard"),
                        gamma=options.get("gamma"), bits=options.get("bits", 8))
    write_png(tmp_path / "expected.png", expected, gamma=options.get("gamma"))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "expected.png").read_bytes()
    assert OpenEXR.File(str(tmp_path / "a.exr")).header()["whiteLuminance"] == EFFICACY
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), IMAGE.astype(np.float32))


def test_heat_maps_are_of_tests_and_of_steps(tmp_path):
    written(RenderFiles(images=(), heatmap=tmp_path / "a"))
    for name, counts, what in (("tests", TESTS, "patch tests"), ("steps", STEPS, "cell steps")):
        np.testing.assert_array_equal(picture(tmp_path / f"a-{name}.png"), false_colour(counts, f"{what} per pixel"))


@pytest.mark.parametrize("decades", [None, 2.5])
def test_every_measurement_has_the_efficacy(monkeypatch, tmp_path, rendered, decades):
    """False colours end below the brightest percent of the pixels, here one of 126."""
    surfaces, rows = {}, {}
    monkeypatch.setattr(surface_file, "write_surfaces",
                        lambda path, scene, light, **options: surfaces.update(options, path=path, light=light))
    monkeypatch.setattr(photometry, "patch_rows", lambda scene, light, efficacy: rows.update(
        light=light, efficacy=efficacy) or [("patch",), (7,)])
    sensors = Sensors(position=np.arange(9.0).reshape(3, 3), normal=np.eye(3), plane=np.array([-1, 0, 0]))
    monkeypatch.setattr(photometry, "read_sensors", lambda path: sensors if path.name == "points.txt" else None)
    stats, text = written(RenderFiles(images=(), exposure=0.3, stats=tmp_path / "s.json", photometry=Photometry(
        illuminance=tmp_path / "a.csv", false_colour=tmp_path / "b", decades=decades, surfaces=tmp_path / "a.glb",
        sensors=tmp_path / "points.txt", sensor_table=tmp_path / "s.csv", efficacy=EFFICACY)))
    assert rendered["sensors"] is sensors
    assert rendered["with_received"]
    assert surfaces == {"path": tmp_path / "a.glb", "light": "light", "efficacy": EFFICACY, "exposure": 0.3}
    assert rows == {"light": "light", "efficacy": EFFICACY}
    assert (tmp_path / "a.csv").read_text() == "patch\n7\n"
    for name, values, what in (("luminance", EFFICACY * IMAGE @ LUMINANCE, "luminance, cd/m2"),
                               ("illuminance", np.pi * EFFICACY * RECEIVED, "illuminance, lux")):
        top = np.quantile(values, 0.99)
        assert top < values.max() / 100
        np.testing.assert_array_equal(picture(tmp_path / f"b-{name}.png"), false_colour(values, what, top=top,
                                                                                                decades=decades))
    lux = np.pi * EFFICACY * MEASURED @ LUMINANCE
    found = [float(line.split(",")[-1]) for line in (tmp_path / "s.csv").read_text().splitlines()[1:]]
    assert found == pytest.approx(lux)
    single, plane = stats["sensors"]
    assert (single["plane"], single["mean"], plane["plane"]) == (None, pytest.approx(lux[0]), 0)
    assert [plane[name] for name in ("minimum", "mean", "maximum", "uniformity")] == pytest.approx(
        [lux[1], lux[1:].mean(), lux[2], lux[1] / lux[1:].mean()])
    assert f"{lux[1:].mean():.5g}" in text
    assert json.loads((tmp_path / "s.json").read_text()) == stats


class Frusta:
    """A caster of another method that does nothing."""

    ray_kinds, specular_rays = ("primary", "hemisphere", "none"), 7

    def counts(self):
        """A count."""
        return {"jobs": 3}

    def summary(self):
        """A line."""
        return "three jobs"


def test_a_method_states_its_share_of_all_rays(rendered):
    caster = Frusta()
    stats, text = written(RenderFiles(images=()), caster=caster)
    assert rendered["frusta"] is caster
    assert stats["settings"] == STATS["settings"] | {"method": "other"}
    assert stats["other"] == {"jobs": 3, "share": 87 / 200}
    assert text.endswith("three jobs\n43.5% of all rays by method other")


@dataclass
class Lamp:
    """A point light that lengthens the scene's name."""

    path: Path

    def scene(self, scene, efficacy):
        """The scene with this light."""
        return replace(scene, name=f"{scene.name} {self.path.name} {efficacy:g}",
                       lights=(PointLight(position=(0, 0, 1), intensity=(1, 1, 1)),))


def test_sky_and_all_luminaires_are_in_the_scene_in_their_order(tmp_path, rendered):
    lamps = [Lamp(tmp_path / name) for name in ("sky", "a.ies", "b.ldt")]
    view = View(daylight=lamps[0], luminaires=tuple(lamps[1:]), zenith=(0, 1, 0), up=(1, 0, 0),
                sky=(3, 4, 5))
    written(RenderFiles(images=(), photometry=Photometry(efficacy=EFFICACY)), view)
    assert rendered["scene"].name == "test sky 90 a.ies 90 b.ldt 90"
    assert tuple(rendered["scene"].up) == (0, 1, 0)
    assert tuple(rendered["scene"].background) == (3, 4, 5)


def test_the_up_of_a_picture_does_not_turn_the_scene(rendered):
    written(RenderFiles(images=()), View(up=(1, 0, 0)))
    assert (tuple(rendered["scene"].up), tuple(rendered["camera"].up)) == (tuple(LIT.up), (1, 0, 0))


@pytest.mark.parametrize("stretch", [1, 1 + 1e-6])
def test_luminaires_in_a_scene_beyond_a_kilometre_are_warned_of(monkeypatch, recwarn, stretch):
    monkeypatch.setattr(render, "open_scene", lambda name, **_: replace(LIT, vertices=LIT.vertices * stretch))
    for view in View(), View(luminaires=(Lamp(Path("a.ies")),)):
        written(RenderFiles(images=()), view)
    assert [warning.category for warning in recwarn] == [InputWarning] * (stretch > 1)


@pytest.mark.parametrize("number", [0, 1])
def test_no_output_is_the_file_of_a_luminaire(number, tmp_path):
    lamps = tuple(Lamp(tmp_path / f"{name}.csv") for name in "ab")
    for lamp in lamps:
        lamp.path.touch()
    with pytest.raises(InputError, match="it is the input"):
        written(RenderFiles(images=(), photometry=Photometry(illuminance=lamps[number].path)),
                View(luminaires=lamps))


@pytest.mark.parametrize("name", ["a-luminance.png", "a-illuminance.png", "b-tests.png", "b-steps.png"])
def test_no_picture_has_the_name_of_one_that_an_option_begins(name, tmp_path):
    with pytest.raises(InputError, match="named twice"):
        RenderFiles(images=(tmp_path / name,), heatmap=tmp_path / "b",
                    photometry=Photometry(false_colour=tmp_path / "a"))


@pytest.mark.parametrize(("name", "suffix"), [("illuminance", ".csv"), ("sensor_table", ".csv"), ("surfaces", ".glb")])
def test_each_measurement_s_file_is_checked_before_the_render(name, suffix, tmp_path):
    for path, message in (("a.txt", f"Name must end in {suffix}"), (f"missing/a{suffix}", "cannot be written")):
        with pytest.raises(InputError, match=message):
            Photometry(sensors=tmp_path / "points.txt", **{name: tmp_path / path})


def test_no_two_tables_are_one_file(tmp_path):
    table = tmp_path / "a.csv"
    with pytest.raises(InputError, match="named twice"):
        RenderFiles(images=(), photometry=Photometry(illuminance=table, sensors=tmp_path / "a.txt", sensor_table=table))
