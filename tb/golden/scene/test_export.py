import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from golden.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.export import FORMATS, export_scene
from golden.scene.gltf import EXACT, split_glb
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.load import load_scene
from golden.scene.material import Material
from golden.scene.scene import Scene

SHARES = ("diffuse", "specular", "transparent", "emission", "refraction_index")
MATERIALS = [
    Material(name="grey", diffuse=(0.31, 0.52, 0.73)),
    Material(name="mirror", specular=(0.9, 0.8, 0.7)),
    Material(name="glass", specular=(0.1, 0.1, 0.1), transparent=(0.9, 0.8, 0.9), refraction_index=1.33),
    Material(name="clear glass", transparent=(0.5, 0.9, 0.9), refraction_index=1.52),
    Material(name="film", diffuse=(0.2, 0.2, 0.1), transparent=(0.5, 0.25, 0.5), refraction_index=1.0),
    Material(name="lamp # 1", diffuse=(0.5, 0.5, 0.5), emission=(17.0, 12.0, 0.25)),
    Material(name="glossy", diffuse=(0.7, 0.1, 0.1), specular=(0.2, 0.3, 0.25)),
    Material(name="black"),
]


def squares(materials, *, up=(0.0, 1.0, 0.0), **properties):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    count = len(materials)
    return Scene(name="squares", vertices=square + np.arange(count)[:, None, None] * (0, 0, 1),
                 material=np.arange(count), materials=tuple(materials), up=up, **properties)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("name", ["cornell", "furnace:4", "lobby"])
def test_a_built_in_scene_comes_back_with_all_its_patches(tmp_path, name, suffix):
    scene = builtin_scene(name)
    path = tmp_path / f"scene{suffix}"
    export_scene(scene, path)
    back = load_scene(path)
    assert len(back) == len(scene)
    assert back.is_triangle.sum() == scene.is_triangle.sum()
    assert np.sort(back.areas) == pytest.approx(np.sort(scene.areas), rel=1e-5)


def by_vertices(scene):
    return np.lexsort(np.rint(1e3 * scene.vertices.mean(axis=1)).T)


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
@pytest.mark.parametrize("name", ["cornell", "furnace:4"])
def test_the_patches_of_a_built_in_scene_have_their_materials_again(tmp_path, name, suffix):
    scene = builtin_scene(name)
    if scene.up != (0, 1, 0):
        turned = scene.vertices[..., [0, 2, 1]] * (1, 1, -1)
        scene = replace(scene, vertices=turned, up=(0, 1, 0), camera=None)
    export_scene(scene, tmp_path / f"scene{suffix}")
    back = load_scene(tmp_path / f"scene{suffix}")
    ours, theirs = by_vertices(scene), by_vertices(back)
    for share in SHARES:
        assert np.allclose(scene.channels(share)[ours], back.channels(share)[theirs], rtol=1e-7, atol=1e-12), share
    assert np.allclose(scene.normals[ours], back.normals[theirs], atol=1e-5)
    if suffix == ".glb":
        assert np.array_equal(scene.two_sided[ours], back.two_sided[theirs])


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
def test_materials_of_all_kinds_come_back(tmp_path, suffix):
    scene = squares(MATERIALS)
    export_scene(scene, tmp_path / f"a{suffix}")
    back = load_scene(tmp_path / f"a{suffix}")
    back = [back.materials[back.material[row]] for row in by_vertices(back)]
    for one, other in zip(scene.materials, back, strict=True):
        for share in SHARES:
            if share != "refraction_index" or max(one.transparent) > 0:
                assert getattr(other, share) == pytest.approx(getattr(one, share), rel=1e-12, abs=1e-15), one.name


def test_only_materials_that_gltf_cannot_say_carry_their_exact_shares(tmp_path):
    export_scene(squares(MATERIALS), tmp_path / "a.glb")
    tree, _ = split_glb((tmp_path / "a.glb").read_bytes())
    exact = {material["name"] for material in tree["materials"] if EXACT in material.get("extras", {})}
    assert exact == {"glass", "glossy", "film"}


def test_panes_and_bodies_of_glass_come_back_from_glb(tmp_path):
    glasses = [Material(name=name, diffuse=(0.1,) * 3, transparent=(0.9,) * 3, refraction_index=1.6, thin=thin)
               for name, thin in (("pane", True), ("body", False))]
    export_scene(squares(glasses), tmp_path / "a.glb")
    back = load_scene(tmp_path / "a.glb")
    assert {material.name: (material.thin, material.refraction_index) for material in back.materials} == {
        "pane": (True, 1.6), "body": (False, 1.6)}


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1)])
def test_spots_and_the_sun_come_back_from_glb(tmp_path, up):
    """Directions turn with the scene; seen in its frame, they stay."""
    direction = np.array((1.0, -2.0, 0.5))
    scene = squares(MATERIALS[:1], up=up, lights=(
        PointLight(position=(1, 2, 3), intensity=(4, 2, 1), cone=Cone(direction=tuple(direction), inner=10, outer=30)),
        DirectionalLight(direction=tuple(direction), irradiance=(8, 4, 2))))
    export_scene(scene, tmp_path / "a.glb")
    spot, sun = load_scene(tmp_path / "a.glb").lights
    turned = direction if up == (0, 1, 0) else np.array((direction[0], direction[2], -direction[1]))
    assert sun.direction == pytest.approx(turned / np.linalg.norm(turned))
    assert spot.cone.direction == pytest.approx(sun.direction)
    assert (spot.cone.inner, spot.cone.outer) == pytest.approx((10, 30))
    assert (spot.intensity, sun.irradiance) == ((4, 2, 1), (8, 4, 2))


def test_camera_lights_and_sides_come_back_from_glb(tmp_path):
    scene = squares(MATERIALS[:2], camera=Camera(eye=(3, 4, 5), target=(0, 1, 0), up=(0, 1, 0), fov=33),
                    lights=(PointLight(position=(1, 2, 3), intensity=(4, 2, 1)),), two_sided=[True, False])
    export_scene(scene, tmp_path / "a.glb")
    back = load_scene(tmp_path / "a.glb")
    assert back.camera.eye == pytest.approx((3, 4, 5))
    assert back.camera.axes == pytest.approx(scene.camera.axes)
    assert back.camera.fov == pytest.approx(33)
    assert back.lights == scene.lights
    assert back.two_sided[by_vertices(back)].tolist() == [True, False]


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0.6, 0, 0.8)])
@pytest.mark.parametrize("suffix", [".glb", ".ply"])
def test_up_is_up_in_the_file(tmp_path, up, suffix):
    scene = replace(builtin_scene("furnace:2"), up=up)
    scene = replace(scene, vertices=scene.vertices * (1, 2, 3), camera=None)
    export_scene(scene, tmp_path / f"a{suffix}")
    back = load_scene(tmp_path / f"a{suffix}")
    height = [np.ptp(part.vertices.reshape(-1, 3) @ np.array(part.up)) for part in (scene, back)]
    assert height[0] == pytest.approx(height[1], rel=1e-6)
    order = [np.argsort(np.abs(part.vertices.mean(axis=1) @ np.array(part.up) - mean), kind="stable")[0]
             for part in (scene, back) for mean in [(part.vertices.reshape(-1, 3) @ np.array(part.up)).max()]]
    assert scene.normals[order[0]] @ scene.up == pytest.approx(back.normals[order[1]] @ np.array(back.up), abs=1e-6)


def test_obj_and_ply_keep_vertices_to_the_bit(tmp_path):
    scene = squares(MATERIALS[:3])
    scene = replace(scene, vertices=scene.vertices / 3 + 0.1)
    for suffix, up in ((".obj", (0, 1, 0)), (".ply", (0, 0, 1))):
        export_scene(replace(scene, up=up), tmp_path / f"a{suffix}")
        back = load_scene(tmp_path / f"a{suffix}")
        assert np.array_equal(back.vertices[by_vertices(back)], scene.vertices)


def test_other_programs_read_the_files(tmp_path):
    for suffix in FORMATS:
        export_scene(builtin_scene("cornell"), tmp_path / f"a{suffix}")
        loaded = trimesh.load_scene(tmp_path / f"a{suffix}")
        assert sum(geometry.area for geometry in loaded.geometry.values()) == pytest.approx(
            builtin_scene("cornell").areas.sum(), rel=1e-4)


def test_the_same_scene_gives_the_same_bytes(tmp_path):
    for suffix in FORMATS:
        for name in ("a", "b"):
            (tmp_path / name).mkdir(exist_ok=True)
            export_scene(builtin_scene("lobby"), tmp_path / name / f"scene{suffix}")
        assert (tmp_path / "a" / f"scene{suffix}").read_bytes() == (tmp_path / "b" / f"scene{suffix}").read_bytes()


def test_the_json_of_a_glb_file_lists_the_extensions_it_uses(tmp_path):
    export_scene(squares(MATERIALS), tmp_path / "a.glb")
    tree, _ = split_glb((tmp_path / "a.glb").read_bytes())
    named = set(json.dumps(tree["materials"]).split('"')) & set(tree["extensionsUsed"])
    assert named == set(tree["extensionsUsed"])


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_path_that_cannot_be_written_is_one_line_and_leaves_nothing(tmp_path, suffix):
    path = tmp_path / "gone" / f"a{suffix}"
    with pytest.raises(InputError) as error:
        export_scene(builtin_scene("cornell"), path)
    assert str(error.value) == f"output {str(path)!r}: cannot be written (No such file or directory)"
    assert not list(tmp_path.iterdir())


def test_an_unknown_suffix_is_refused(tmp_path):
    with pytest.raises(InputError) as error:
        export_scene(builtin_scene("cornell"), tmp_path / "a.doc")
    assert str(error.value) == (f"output {str(tmp_path / 'a.doc')!r}: Name must end in .glb or .obj or .ply or .stl, "
                                "not '.doc'")
