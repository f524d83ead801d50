import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.export import FORMATS, export_scene, rotation_between
from golden.scene.gltf import split_glb
from golden.scene.gltf_material import EXACT
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.load import load_scene
from golden.scene.material import Material
from golden.scene.scene import Scene
from tb.lib.schedules import SETTINGS

SHARES = ("diffuse", "specular", "transparent", "emission")
MATERIALS = [
    Material(name="grey", diffuse=(0.31, 0.52, 0.73)),
    Material(name="mirror", specular=(0.9, 0.8, 0.7)),
    Material(name="glass", specular=(0.1, 0.1, 0.1), transparent=(0.9, 0.8, 0.9), refraction_index=1.33),
    Material(name="clear glass", transparent=(0.5, 0.9, 0.9), refraction_index=1.52),
    Material(name="film", diffuse=(0.2, 0.2, 0.1), transparent=(0.5, 0.25, 0.5), refraction_index=1.0),
    Material(name="lamp # 1", diffuse=(0.5, 0.5, 0.5), emission=(17.0, 12.0, 0.25)),
    Material(name="lamp", emission=(2.0, 1.5, 0.25)),
    Material(name="dim", emission=(0.5, 0.25, 0.0)),
    Material(name="glossy", diffuse=(0.7, 0.1, 0.1), specular=(0.2, 0.3, 0.25)),
    Material(name="black"),
]


def squares(materials, *, up=(0.0, 1.0, 0.0), **properties):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    count = len(materials)
    return Scene(name="squares", vertices=square + np.arange(count)[:, None, None] * (0, 0, 1),
                 material=np.arange(count), materials=tuple(materials), up=up, **properties)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_built_in_scene_comes_back_with_all_its_patches(tmp_path, suffix):
    scene = builtin_scene("lobby")
    path = tmp_path / f"scene{suffix}"
    export_scene(scene, path)
    back = load_scene(path)
    assert len(back) == len(scene)
    assert back.is_triangle.sum() == scene.is_triangle.sum()
    assert np.sort(back.areas) == pytest.approx(np.sort(scene.areas), rel=1e-5)


QUARTER = st.sampled_from((0.0, 0.25, 0.5, 1.0))
PLACE = st.tuples(*[st.integers(-3, 3)] * 3)


@st.composite
def materials(draw):
    """Materials of any mixture of shares that sum to at most 1, in glass and panes, glowing or not."""
    shares = np.array([[draw(QUARTER) for _ in range(3)] for _ in range(3)])
    diffuse, specular, transparent = (tuple(row) for row in (shares / np.maximum(shares.sum(axis=0), 1)).tolist())
    index = draw(st.sampled_from((1.0, 1.33, 1.6)))
    emission = tuple(draw(st.sampled_from((0.0, 0.5, 17.0))) for _ in range(3))
    return Material(name="it", diffuse=diffuse, specular=specular, transparent=transparent, refraction_index=index,
                    thin=index > 1 and draw(st.booleans()), emission=emission)


@st.composite
def scenes(draw):
    """Quadrilaterals and triangles of any materials and sides under any up, with a camera and lights of all kinds."""
    count, up = draw(st.integers(1, 3)), draw(st.sampled_from(
        ((0, 1, 0), (0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0.6, 0, 0.8))))
    vertices = np.array([[(0, 0, z), (2, 0, z), (1, 1, z), draw(st.sampled_from(((0, 1, z), (1, 1, z))))]
                         for z in range(count)], dtype=float) / 3
    direction = draw(PLACE.filter(any))
    lights = (PointLight(position=draw(PLACE), intensity=(4, 2, 1)),
              PointLight(position=draw(PLACE), intensity=(4, 0, 1), cone=Cone(direction=direction, inner=10, outer=30)),
              DirectionalLight(direction=direction, irradiance=(8, 4, 2)))
    # In no direction of an up.
    camera = Camera(eye=draw(PLACE), target=(9, 8, 7), up=(1, -2, 3), fov=33)
    names = st.sampled_from(("m", "m\\", "m\\ #", "a b\\"))
    return Scene(name="drawn", vertices=vertices, material=np.arange(count), up=tuple(map(float, up)),
                 materials=tuple(replace(draw(materials()), name=draw(names)) for _ in range(count)),
                 two_sided=[draw(st.booleans()) for _ in range(count)], camera=camera, lights=lights)


@settings(SETTINGS, max_examples=40)
@given(scene=scenes(), suffix=st.sampled_from((".glb", ".glb", ".obj", ".ply", ".stl")))
def test_a_drawn_scene_comes_back_with_all_that_its_format_holds(tmp_path_factory, scene, suffix):
    path = tmp_path_factory.getbasetemp() / f"a{suffix}"
    export_scene(scene, path)
    back = load_scene(path)
    turn = rotation_between(scene.up, back.up)
    np.testing.assert_allclose(turn @ scene.up, back.up, atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) > 0
    middles = scene.vertices.mean(axis=1) @ turn.T
    order = np.linalg.norm(back.vertices.mean(axis=1) - middles[:, None], axis=2).argmin(axis=1)
    assert sorted(order) == list(range(len(back)))
    exact = {"rtol": 0, "atol": 1e-15 if suffix in (".obj", ".ply") else 1e-6}
    for ours, theirs in zip(scene.vertices @ turn.T, back.vertices[order], strict=True):
        away = np.abs(theirs[:, None] - ours).max(axis=2)
        np.testing.assert_allclose(away.min(axis=1), 0, **exact)
        np.testing.assert_allclose(away.min(axis=0), 0, **exact)
    np.testing.assert_allclose(back.normals[order], scene.normals @ turn.T, atol=1e-5)
    if suffix in (".glb", ".obj"):
        for share in SHARES:
            np.testing.assert_allclose(back.channels(share)[order], scene.channels(share), rtol=1e-7, atol=1e-12)
    if suffix == ".glb":
        glass = scene.channels("transparent").any(axis=1)
        for name in ("thin", "refraction_index"):
            for number in np.flatnonzero(glass):
                assert getattr(back.materials[back.material[order[number]]], name) == getattr(
                    scene.materials[number], name)
        assert back.two_sided[order].tolist() == scene.two_sided.tolist()
        np.testing.assert_allclose(back.camera.eye, turn @ scene.camera.eye, atol=1e-9)
        np.testing.assert_allclose(back.camera.axes, scene.camera.axes @ turn.T, atol=1e-9)
        assert back.camera.fov == pytest.approx(33)
        for ours, theirs in zip(scene.lights, back.lights, strict=True):
            if isinstance(ours, PointLight):
                np.testing.assert_allclose(theirs.position, turn @ ours.position, atol=1e-9)
                assert theirs.intensity == ours.intensity
                assert (ours.cone is None) == (theirs.cone is None)
            else:
                assert theirs.irradiance == ours.irradiance
            ours, theirs = (getattr(light, "cone", light) for light in (ours, theirs))
            if ours is not None:
                np.testing.assert_allclose(theirs.direction, turn @ ours.direction / np.linalg.norm(ours.direction),
                                           atol=1e-9)
        assert (back.lights[1].cone.inner, back.lights[1].cone.outer) == pytest.approx((10, 30))


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
@pytest.mark.parametrize("channel", range(3))
def test_a_channel_that_transmits_all_leaves_the_others_their_shares(tmp_path, channel, suffix):
    transparent, diffuse = np.eye(3)[channel], 0.5 * (1 - np.eye(3)[channel])
    scene = squares([Material(name="it", diffuse=tuple(diffuse), transparent=tuple(transparent), refraction_index=1.0)])
    export_scene(scene, tmp_path / f"a{suffix}")
    back = load_scene(tmp_path / f"a{suffix}")
    for share in SHARES:
        np.testing.assert_allclose(back.channels(share), scene.channels(share), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_scene_is_not_written_over_the_file_that_it_was_read_from(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    export_scene(squares(MATERIALS), path)
    before = path.read_bytes()
    with pytest.raises(InputError, match="it is the input"):
        export_scene(load_scene(path), path)
    assert path.read_bytes() == before


def test_only_materials_that_gltf_cannot_say_carry_their_exact_shares(tmp_path):
    export_scene(squares(MATERIALS), tmp_path / "a.glb")
    tree, _ = split_glb((tmp_path / "a.glb").read_bytes())
    exact = {material["name"] for material in tree["materials"] if EXACT in material.get("extras", {})}
    assert exact == {"glass", "glossy", "film"}


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
