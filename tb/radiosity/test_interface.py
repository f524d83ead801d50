"""The public names: what they load, what they accept, what they refuse."""

import json
import random
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import radiosity
from golden.light.photometry.quantities import candela_per_m2
from tb.lib.seed import SEED

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
# Two squares as points and faces, the second one above the first.
POINTS = np.array([*SQUARE, *((x, y, 1) for x, y, _ in SQUARE)], dtype=float)
FACES = [[0, 1, 2, 3], [7, 6, 5, 4]]


# The names that are of the machine and load its modules.
MACHINE = {"MachineCastResult", "export_verilog", "machine", "visible"}


def test_public_names_load_nothing_of_the_machine():
    """And the package itself nothing at all, not even numpy; but for those that are of the machine."""
    program = ("import sys, radiosity\n"
               "print(*(name for name in ('numpy', 'golden') if name in sys.modules))\n"
               f"for name in set(radiosity.__all__) - {MACHINE!r}: getattr(radiosity, name)\n"
               "print(*(name for name in sys.modules if name.startswith(('hw', 'amaranth', 'radiosity.machines', "
               "'golden.engine.config', 'golden.engine.ctu', 'golden.engine.icu', 'golden.engine.jobs', "
               "'golden.engine.memsys', 'golden.engine.schedule'))))")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "\n\n"


def test_every_public_name_is_there():
    assert set(radiosity.__all__) <= set(dir(radiosity))
    with pytest.raises(AttributeError, match="has no attribute 'scene_of'"):
        _ = radiosity.scene_of


def test_points_and_faces_are_the_corners_that_they_name():
    scene = radiosity.Scene.from_arrays(POINTS, FACES, names=["floor", "lid"])
    np.testing.assert_array_equal(scene.vertices, POINTS[np.array(FACES)])
    np.testing.assert_array_equal(scene.normals, [(0, 0, 1), (0, 0, -1)])
    assert [material.name for material in scene.materials] == ["floor", "lid"]
    assert repr(scene) == "<Scene 'facets': 2 patches, 2 materials, 0 lights, 1 x 1 x 1>"


def test_a_mesh_of_pyvista_is_its_faces():
    """Of triangles and quadrilaterals, as `pyvista.PolyData` lists them; names from an array of cells."""
    mesh = SimpleNamespace(points=POINTS, faces=np.array([4, 0, 1, 2, 3, 3, 7, 6, 5]), cell_data={"part": ["a", "b"]})
    scene = radiosity.Scene.from_pyvista(mesh, names="part")
    np.testing.assert_array_equal(scene.vertices, POINTS[[[0, 1, 2, 3], [7, 6, 5, 5]]])
    assert scene.is_triangle.tolist() == [False, True]
    mesh.faces = np.array([5, 0, 1, 2, 3, 4])
    with pytest.raises(radiosity.InputError, match="three or four corners, not 5"):
        radiosity.Scene.from_pyvista(mesh)


@pytest.mark.parametrize(("call", "parameter"), [
    (lambda: radiosity.load("furnace:1", zenith=(0, 0, 0)), "zenith"),
    (lambda: radiosity.Scene.from_arrays(POINTS, [[0, 1, 2, 8]]), "faces"),
    (lambda: radiosity.Scene.from_arrays(POINTS, FACES, names=["floor"]), "names"),
    (lambda: radiosity.Scene.from_arrays(POINTS, FACES, two_sided=2), "two_sided"),
    (lambda: radiosity.Camera(eye=(0, 0, 0), target=(0, 0, 0)), "target"),
    (lambda: radiosity.Rays([[0, 0, np.nan]], [[0, 0, 1]]), "origin"),
    (lambda: radiosity.Rays([[0, 0, 0]], [[0, 0, 0]]), "direction"),
    (lambda: radiosity.Rays([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]]), "direction"),
    (lambda: radiosity.Rays([[0, 0, 0]], [[0, 0, 1]], tmax=[-1]), "tmax"),
    (lambda: radiosity.PointLight(position=(0, 0, 0), intensity=(-1, 0, 0)), "intensity"),
    (lambda: radiosity.Sensors(position=[(0, 0, np.nan)], normal=[(0, 0, 1)]), "position"),
    (lambda: radiosity.luminaire(radiosity.load("furnace:1"), "missing.ies", (0, 0, 1)), "path"),
    (lambda: radiosity.ViewFactors.open("missing.npz"), "path"),
    (lambda: radiosity.view_factors(SQUARES, more=2), "more"),
    (lambda: radiosity.render(radiosity.load("furnace:1"), size=(True, 4)), "width"),
    (lambda: radiosity.render(radiosity.load("furnace:1"), size=7), "size"),
    (lambda: radiosity.render(radiosity.load("furnace:1"), samples=3), "samples"),
    (lambda: radiosity.render(radiosity.load("furnace:1"), jobs=True), "jobs"),
    (lambda: radiosity.view_factors(SQUARES, error=1.0), "error"),
    (lambda: radiosity.view_factors(SQUARES, seed=True), "seed"),
    (lambda: radiosity.view_factors(SQUARES, unit="mile"), "unit"),
    (lambda: radiosity.cast(radiosity.load("furnace:1"), RAYS, method="magic"), "method"),
    (lambda: radiosity.cast(radiosity.load("furnace:1"), RAYS, jobs=0), "jobs"),
    (lambda: radiosity.machine(radiosity.load("furnace:1"), patch=0, clusters=3), "clusters"),
    (lambda: radiosity.machine(radiosity.load("furnace:1"), patch=6), "patch"),
    (lambda: radiosity.machine(radiosity.load("furnace:1"), patch=0, casts=True), "casts"),
    (lambda: radiosity.machine(radiosity.load("furnace:1"), patch=0, preset="huge"), "preset"),
    (lambda: radiosity.visible(radiosity.load("furnace:1"), patch=6), "patch"),
    (lambda: radiosity.visible(radiosity.load("furnace:1"), origin=(0, 0)), "origin"),
    (lambda: radiosity.visible(radiosity.load("furnace:1"), patch=0, method="grid"), "method"),
    (lambda: radiosity.visible(radiosity.load("furnace:1"), patch=0, method="machine", preset="huge"), "preset"),
    (lambda: radiosity.export_verilog("core", top="gpu"), "top"),
    (lambda: radiosity.export_verilog("core", period=0), "period"),
    (lambda: radiosity.export_verilog("core", parameters={"icu.threads": 2}), "parameters"),
    (lambda: radiosity.sky(radiosity.load("furnace:1"), "blue"), "sky"),
    (lambda: radiosity.sky(radiosity.load("furnace:1"), place=(48, 11)), "date"),
    (lambda: radiosity.sky(FURNACE, sun=(0, 45), place=(48, 11), date=datetime(2026, 6, 21, tzinfo=UTC)), "sun")])
def test_an_input_error_is_a_value_error_that_names_its_parameter(call, parameter):
    with pytest.raises(ValueError, match=r"^[^\n]+$") as caught:
        call()
    assert isinstance(caught.value, radiosity.InputError)
    assert caught.value.parameter == parameter


SQUARES = POINTS[np.array(FACES)]
FURNACE = radiosity.load("furnace:1")
RAYS = radiosity.Rays([[0.5, 0.5, 0.5]], [[0, 0, 1]])


@pytest.mark.parametrize(("call", "counts", "pairs", "points"), [
    (lambda **given: radiosity.machine(FURNACE, **{"patch": 0, "rays": (8, 8)} | given),
     ("patch", "casts", "latency", "clusters"), ("rays",), ()),
    (lambda **given: radiosity.machine(FURNACE, **given), (), ("screen",), ()),
    (lambda **given: radiosity.machine(FURNACE, **{"origin": (0, 0, 0), "normal": (0, 0, 1)} | given), (), (),
     ("origin", "normal")),
    (lambda **given: radiosity.visible(FURNACE, **{"patch": 0} | given), ("patch",), (), ()),
    (lambda **given: radiosity.visible(FURNACE, **given), (), (), ("origin",)),
    (lambda **given: radiosity.visible(FURNACE, patch=0, method="machine", **given), ("clusters",), (), ()),
    (lambda **given: radiosity.render(FURNACE, **{"size": (3, 2), "samples": 1} | given),
     ("samples", "elements", "depth", "jobs", "seed"), ("rays",), ()),
    (lambda **given: radiosity.cast(FURNACE, RAYS, **given), ("jobs",), (), ()),
    (lambda **given: radiosity.view_factors(SQUARES, **given), ("jobs", "seed"), (), ())])
def test_what_is_no_number_of_its_kind_is_refused_before_the_work(call, counts, pairs, points, monkeypatch):
    """Of all functions; numpy's floats are no whole numbers either."""
    for module in "machine", "visible":
        monkeypatch.setattr(f"radiosity.api.{module}.opened_machine", None)
    tenth = random.Random(SEED).randrange(1, 9) / 10
    numbers = 1 + tenth, np.float64(1 + tenth), np.nan, True, np.True_, -1, "x"
    for name, value in [*((name, value) for name in counts for value in numbers),
                        *((name, value) for name in pairs for value in (
                            7, (), (8,), (8, 8, 8), (8 + tenth, 8), (8, np.nan), (True, 8), np.array([8.0, 8.0]))),
                        *((name, value) for name in points for value in (
                            7, (), (0, 1), (0, 1, np.nan), (0, np.inf, 1), ("x", 0, 1), [[0, 0, 1]]))]:
        with pytest.raises(radiosity.InputError, match=" must be ") as caught:
            call(**{name: value})
        assert caught.value.parameter == name


@pytest.fixture(scope="module")
def picture():
    """A picture with light at one sensor."""
    drawn = radiosity.render(FURNACE, size=(2, 1), samples=1, rays=(8, 4), elements=6)
    return replace(drawn, sensors=np.ones((1, 3)))


@pytest.mark.parametrize(("call", "methods"), [
    (lambda **given: radiosity.cast(FURNACE, RAYS, **given), ("naive", "embree")),
    (lambda **given: radiosity.visible(FURNACE, patch=0, **given), ("naive-fixed",)),
    (lambda **given: radiosity.render(FURNACE, **given), ("naive", "embree", "naive-fixed"))])
@pytest.mark.parametrize("cell", [-1, 0.25, np.nan])
def test_a_method_without_cells_has_no_cell_size(call, methods, cell):
    for method in methods:
        with pytest.raises(radiosity.InputError, match=f"Cell size must be left out with method {method}") as caught:
            call(method=method, cell=cell)
        assert caught.value.parameter == "cell"


@pytest.mark.parametrize(("name", "value", "says"), [
    ("clusters", 2, "left out"), ("clusters", 3, "left out"), ("parameters", {"icu.rays": 4096}, "left out"),
    ("preset", "huge", "one of")])
@pytest.mark.parametrize("method", ["shelling", "naive-fixed"])
def test_what_is_of_the_machine_goes_with_no_other_method(method, name, value, says):
    with pytest.raises(radiosity.InputError, match=f"{name.capitalize()} must be {says}") as caught:
        radiosity.visible(FURNACE, patch=0, method=method, **{name: value})
    assert caught.value.parameter == name


@pytest.mark.parametrize("efficacy", [0, -1, -0.0, np.nan, np.inf, -np.inf, np.float32(-5), True, "x"])
def test_a_luminous_efficacy_is_finite_and_above_0(efficacy, picture, tmp_path):
    """Wherever one is given."""
    for call in (lambda: radiosity.sky(FURNACE, "cie-overcast", efficacy=efficacy),
                 lambda: radiosity.luminaire(FURNACE, "lamp.ies", (0, 0, 1), efficacy=efficacy),
                 lambda: picture.illuminance(efficacy), lambda: candela_per_m2(picture.image, efficacy),
                 lambda: picture.save(tmp_path / "a.exr", efficacy=efficacy)):
        with pytest.raises(radiosity.InputError, match="Efficacy must be finite and above 0") as caught:
            call()
        assert caught.value.parameter == "efficacy"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("whole", [np.int8, np.uint16, np.int64])
def test_a_machine_of_numpys_numbers_is_that_of_pythons(whole, monkeypatch):
    """The same configuration, which is JSON, and the same memory."""
    opened = []

    def stop(config, **given):
        opened.append((json.dumps(config.parameters()), given, {type(value) for value in given.values()}))
        raise InterruptedError

    monkeypatch.setattr("radiosity.api.machine.opened_machine", stop)
    monkeypatch.setattr("radiosity.api.visible.opened_machine", stop)

    def call_all(number, pair):
        given = {"clusters": number(2), "parameters": {"icu.side_bits": number(8)}}
        for function, more in ((radiosity.visible, {"patch": number(3), "method": "machine"}),
                               (radiosity.machine, {"patch": number(3), "rays": pair([8, 16]), "casts": number(2),
                                                    "latency": number(9)}),
                               (radiosity.machine, {"screen": pair([16, 12])})):
            with pytest.raises(InterruptedError):
                function(FURNACE, **given, **more)

    call_all(int, tuple)
    call_all(whole, lambda values: np.array(values, dtype=whole))
    assert opened[:3] == opened[3:]


def test_numbers_of_numpy_are_numbers():
    picture = radiosity.render(radiosity.load("furnace:1"), size=np.array([3, 2]), samples=np.int64(1),
                               rays=np.array([16, 4]), elements=np.int32(6), jobs=np.int64(1), seed=np.uint8(3))
    assert picture.image.shape == (2, 3, 3)
    assert picture.statistics.total.rays == sum(count.rays for count in picture.statistics.rays.values())
    assert picture.statistics.rays["primary"].rays == 6
    assert repr(picture).startswith("<RenderResult: 3 x 2 pixels, ")


def test_pixels_of_a_picture_are_those_of_its_file(tmp_path):
    picture = radiosity.render(radiosity.load("furnace:1"), size=(3, 2), samples=1)
    picture.save(tmp_path / "a.png", exposure=2, curve="linear")
    with Image.open(tmp_path / "a.png") as stored:
        np.testing.assert_array_equal(picture.pixels(exposure=2, curve="linear"), np.asarray(stored))


def test_exchange_takes_values_by_the_names_of_surfaces():
    factors = radiosity.view_factors(SQUARES, names=["floor", "lid"])
    by_name = factors.exchange(temperature={"floor": 300}, emissivity={"floor": 0.9, "lid": 0.8}, flux={"lid": 0},
                               sky_temperature=200)
    by_patch = factors.exchange(temperature=[300, np.nan], emissivity=[0.9, 0.8], flux=[np.nan, 0], sky_temperature=200)
    np.testing.assert_array_equal(by_name.temperature, by_patch.temperature)
    with pytest.raises(radiosity.InputError, match="not of 'roof'") as caught:
        factors.exchange(temperature={"roof": 1}, emissivity=1)
    assert caught.value.parameter == "temperature"
    with pytest.raises(radiosity.InputError, match="patch 1: Emissivity must be 0 to 1, not 2") as caught:
        factors.exchange(temperature=300, emissivity=[0, 2])
    assert caught.value.parameter == "emissivity"
    assert repr(by_name).startswith("<Exchange: 2 patches, temperatures ")


def test_script_f_between_surfaces_by_their_names():
    """Two black plates: the share that leaves one and arrives at the other is F."""
    factors = radiosity.view_factors(SQUARES, names=["floor", "lid"])
    np.testing.assert_array_equal(factors.by_surface().F.toarray(), factors.F.toarray())
    np.testing.assert_allclose(factors.script_f(emissivity={"floor": 1, "lid": 1}), factors.F.toarray(), atol=1e-12)


def test_parameters_of_a_machine_stay_as_they_are_given():
    with pytest.raises(radiosity.InputError, match=r"sets noc.columns .* cannot be given"):
        radiosity.machine(FURNACE, patch=0, clusters=2, parameters={"noc.columns": 2})


def test_a_ray_hits_the_nearest_patch_or_any_one():
    scene = radiosity.load("furnace:1")
    hits = radiosity.cast(scene, RAYS, jobs=1)
    assert repr(hits) == "<Hits: 1 of 1 ray>"
    assert (hits.t.item(), scene.normals[hits.patch.item()].tolist()) == (0.5, [0, 0, -1])
    blocked = radiosity.cast(scene, radiosity.Rays([[0.5, 0.5, 0.5]], [[0, 0, 1]], tmax=[0.4]), any_hit=True)
    assert blocked.patch.item() == -1


def test_a_square_hides_the_light_from_what_is_behind_it():
    """The light is above the middle of the lower square of two; it shines through between them, and past the lower."""
    scene = radiosity.Scene.from_arrays(POINTS, FACES)
    targets = radiosity.Sensors(position=[(0.5, 0.5, 0.1), (0.5, 0.5, -1), (5, 0.5, 0.2), (0.5, 0.5, 2)],
                                normal=np.tile([0, 0, 1], (4, 1)))
    for method in "shelling", "naive-fixed":
        seen = radiosity.visible(scene, origin=(0.5, 0.5, 0.5), targets=targets, method=method)
        assert seen.tolist() == [True, False, True, False]
    assert radiosity.visible(scene, patch=0).tolist() == [True, True]


def test_sensors_of_a_plane_are_the_centres_of_its_fields():
    sensors = radiosity.Sensors.on_plane((1, 2, 3), (4, 0, 0), (0, 2, 0), (2, 1))
    np.testing.assert_array_equal(sensors.position, [(2, 3, 3), (4, 3, 3)])
    np.testing.assert_array_equal(sensors.normal, [(0, 0, 1)] * 2)
    for steps in (0, 1), (True, 1), (1.5, 1):
        with pytest.raises(radiosity.InputError, match="Steps must be two whole numbers") as caught:
            radiosity.Sensors.on_plane((0, 0, 0), (1, 0, 0), (0, 1, 0), steps)
        assert caught.value.parameter == "steps"
