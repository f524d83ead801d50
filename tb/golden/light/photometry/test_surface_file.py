import json

import numpy as np
import pytest
import trimesh

from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.light.indirect import indirect_light
from golden.light.photometry.quantities import lux
from golden.light.photometry.surface_file import write_surfaces
from golden.light.tally import Tally
from golden.scene.material import Material
from golden.scene.refine import refine
from tb.golden.light.scenes import rectangle, scene_of

RED = Material(name="red", diffuse=(0.8, 0.1, 0.1))
LAMP = Material(name="lamp", emission=(4, 2, 1))
TRIANGLE = np.array([(3, 0, 0), (4, 0, 0), (3, 1, 0), (3, 1, 0)], dtype=float)
SCENE = scene_of((rectangle((0, 0, 0), (2, 0, 0), (0, 1, 0)), RED), (TRIANGLE, RED, {"two_sided": True}),
                 (rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0)), LAMP), background=(0.5, 0.5, 0.5))


@pytest.fixture(scope="module")
def light():
    caster = Grid(SCENE)
    return indirect_light(SCENE, refine(SCENE, max_edge=0.5), caster, caster, Tally(), hemisphere=Hemisphere(16, 4),
                          solver="conjugate-gradient", light_samples=4, seed=0)


def accessor(tree, data, number):
    entry = tree["accessors"][number]
    view = tree["bufferViews"][entry["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[entry["type"]]
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    return np.frombuffer(data, {5126: "<f4", 5125: "<u4"}[entry["componentType"]], width * entry["count"],
                         start).reshape(-1, width)


@pytest.fixture(scope="module")
def stored(light, tmp_path_factory):
    """The attributes and triangles of a file, whose y is the scene's z."""
    path = tmp_path_factory.mktemp("surfaces") / "a.glb"
    write_surfaces(path, SCENE, light, efficacy=100.0, exposure=0.25)
    data = path.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    tree, binary = json.loads(data[20:20 + length]), data[28 + length:]
    (primitive,) = tree["meshes"][0]["primitives"]
    assert tree["materials"][primitive["material"]]["extensions"] == {"KHR_materials_unlit": {}}
    found = {name: accessor(tree, binary, number) for name, number in primitive["attributes"].items()}
    return found | {"faces": accessor(tree, binary, primitive["indices"]).reshape(-1, 3), "path": path}


def test_all_sides_are_triangles_that_face_out_of_them(stored):
    mesh = trimesh.Trimesh(stored["POSITION"], stored["faces"], process=False)
    assert mesh.area == pytest.approx(SCENE.areas.sum() + SCENE.areas[1], rel=1e-6)
    normals = np.unique(mesh.face_normals.round(6) + 0.0, axis=0)
    assert {tuple(normal) for normal in normals.tolist()} == {(0, 1, 0), (0, -1, 0)}
    upward = mesh.area_faces[mesh.face_normals[:, 1] > 0].sum()
    assert upward == pytest.approx(SCENE.areas[:2].sum(), rel=1e-6)


def test_an_element_alone_on_its_patch_has_its_own_values_at_its_corners(stored, light):
    """The lamp, in four elements with the same emission."""
    of_lamp = np.repeat(light.elements.patch == 2, 4)
    np.testing.assert_allclose(stored["_RADIOSITY"][of_lamp], lux(np.array(LAMP.emission), 100.0), rtol=1e-6)
    np.testing.assert_allclose(stored["COLOR_0"][of_lamp], np.tile((1, 0.5, 0.25), (of_lamp.sum(), 1)), rtol=1e-6)


def test_corners_share_the_mean_of_the_elements_around_them(stored, light):
    elements = light.elements
    corner = np.flatnonzero(np.isclose(stored["POSITION"], (1, 0, -0.5)).all(axis=1))
    around = np.flatnonzero((elements.patch == 0) & (np.abs(elements.centre - (1, 0.5, 0)) < 0.5).all(axis=1))
    assert len(corner) == len(around) == 4
    expected = lux(light.received[around], 100.0).mean()
    np.testing.assert_allclose(stored["_ILLUMINANCE"][corner, 0], expected, rtol=1e-5)


def test_other_programs_read_the_file(stored):
    (mesh,) = trimesh.load_scene(stored["path"]).geometry.values()
    np.testing.assert_array_equal(mesh.vertex_attributes["_ILLUMINANCE"], stored["_ILLUMINANCE"])
