import warnings
from functools import partial

import numpy as np
import pytest

from golden.base.errors import InputWarning
from golden.base.summary import summary
from golden.cast.grid import Grid
from golden.light.limits import not_computed, warn_of_flush_lights, warn_of_near_lights, warn_of_tiny_patches
from golden.light.near_lights import RESOLVED, NearPairs, near_knots
from golden.scene.builtin.shapes import box
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.refine import refine
from golden.scene.tessellate import sphere
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.golden.render.pictures import looking, picture

GREY = Material(name="grey", diffuse=(0.5, 0.5, 0.5))
LAMP = Material(name="panel", emission=(1, 1, 1))
CEILING = rectangle((0, 0, 0), (4, 0, 0), (0, 4, 0))
SKY = 1.0, 1.0, 1.0


def warned(gap, *, two_sided=True, below=GREY, edge=0.5, finer=False):
    panel = rectangle((1, 1, gap), (0, 1, 0), (1, 0, 0))
    scene = scene_of((CEILING, below), (panel[::-1] if not two_sided else panel, LAMP, {"two_sided": two_sided}))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pairs = NearPairs(scene, Grid(scene))
        refinement = refine(scene, max_edge=edge, finer=partial(near_knots, scene, pairs) if finer else None)
        warn_of_near_lights(scene, refinement, pairs)
    return [str(warning.message) for warning in caught]


@pytest.mark.parametrize("gap", [1e-3, 0.9 * RESOLVED * 0.5])
def test_a_panel_nearer_than_elements_resolve_is_named_once(gap):
    (message,) = warned(gap)
    assert f"a light of material 'panel' is {gap:.3g} from a surface whose elements are 0.5 long" in message


def test_the_nearest_of_several_panels_is_named():
    """By its distance over the length of the elements before it."""
    panels = [(rectangle((x, 1, gap), (0, 0.5, 0), (0.5, 0, 0)), Material(name=f"panel {gap}", emission=(1, 1, 1)))
              for x, gap in ((0.5, 0.05), (1.5, 0.01), (2.5, 0.03))]
    scene = scene_of((CEILING, GREY), *((panel[::-1], lamp, {"two_sided": True}) for panel, lamp in panels))
    with pytest.warns(InputWarning) as caught:
        warn_of_near_lights(scene, refine(scene, max_edge=0.5), NearPairs(scene, Grid(scene)))
    assert len(caught) == 1
    assert "a light of material 'panel 0.01' is 0.01 from a surface" in str(caught[0].message)


@pytest.mark.parametrize("more", [{"gap": 0.2}, {"gap": 0.01, "two_sided": False}, {"gap": 0.01, "below": BLACK},
                                  {"gap": 0.01, "edge": 0.02}, {"gap": 0.01, "finer": True}])
def test_a_light_that_elements_resolve_is_not_named(more):
    assert warned(**more) == []


@pytest.mark.parametrize(("far", "says"), [(1e30, [
    "scene 'test': 1 patch of 2 smaller than 1.49e+22, which rays miss in a scene of 1e+30: is a vertex astray?"]),
    (1e6, [])])
def test_patches_that_a_stray_vertex_makes_tiny_are_named(far, says):
    scene = scene_of((CEILING, GREY), (rectangle((0, 0, 0), (far, 0, 0), (0, 0, far)), GREY))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_tiny_patches(scene, Grid(scene).least)
    assert [str(warning.message) for warning in caught] == says


def test_a_light_in_the_plane_of_a_surface_that_it_covers_is_named_once():
    panels = [rectangle((x, 1, 0), (0, 1, 0), (1, 0, 0)) for x in (0, 1)]
    scene = scene_of((CEILING, GREY, {"two_sided": True}), (panels, LAMP), (panels, GREY))
    with pytest.warns(InputWarning) as caught:
        warn_of_flush_lights(scene)
    assert [str(warning.message) for warning in caught] == [
        "scene 'test': a light of material 'panel' lies in a surface of material 'grey', and 3 more pairs: rays meet "
        "either of them; a small distance helps"]


@pytest.mark.parametrize("place", [(1, 1, 1e-3), (4, 0, 0)])
def test_a_light_before_or_beside_a_surface_is_not_in_it(place):
    with warnings.catch_warnings(record=True) as found:
        warn_of_flush_lights(scene_of((CEILING, GREY), (rectangle(place, (1, 0, 0), (0, 1, 0)), LAMP)))
    assert not found


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
def test_an_image_names_what_is_missing_in_it():
    mirror, glass = Material(name="mirror", specular=(1, 1, 1)), Material(name="glass", transparent=(1, 1, 1))
    ball = sphere((0, 0, 1), 0.5, segments=8)
    plain = scene_of((CEILING, GREY), background=SKY)
    assert not_computed(plain, has_buried=False) == []
    sheen = Material(name="sheen", specular=(0.4, 0.4, 0.4))
    lamp = PointLight(position=(1, 1, 1), intensity=(1, 1, 1))
    assert not_computed(scene_of((CEILING, mirror), background=SKY), has_buried=False) == []
    assert len(not_computed(scene_of((CEILING, sheen), background=SKY), has_buried=False)) == 1
    assert len(not_computed(scene_of((CEILING, mirror), lights=(lamp,)), has_buried=False)) == 1
    assert len(not_computed(scene_of((box((0, 0, 0), (1, 1, 1)), glass), background=SKY), has_buried=False)) == 1
    sheet = Material(name="sheet", transparent=(1, 1, 1), thin=True)
    assert not_computed(scene_of((CEILING, sheet), background=SKY), has_buried=False) == []
    assert len(not_computed(scene_of((CEILING, sheet), lights=(lamp,)), has_buried=False)) == 1
    scene = scene_of((CEILING, sheen), (ball, glass, {"smooth": True}), background=SKY)
    missing = not_computed(scene, has_buried=True)
    assert [line.split(":")[0].rsplit(" (", 1)[0] for line in missing] == [
        "spots of light that 'sheen'", "spots of light that glass mirrors, 'glass'",
        "light that curved glass bends, 'glass'", "edges of light on smooth surfaces finer than their facets, 'glass'",
        "light along the lines where curved bodies enter others"]
    assert all(line.count(":") == line.count(";") == 1 for line in missing), "what it is: what it means; what helps"


def test_a_line_names_materials_their_share_and_the_size_of_steps():
    """Four of five squares of area 1 mirror a little; a tetrahedron's edges are 2 sqrt(2)."""
    scene = scene_of(*(([rectangle((3 * k, 0, 0), (1, 0, 0), (0, 1, 0))],
                        Material(name=name, specular=(0.4, 0.4, 0.4) if k else (0, 0, 0)))
                       for k, name in enumerate("abcde")), background=SKY)
    line, = not_computed(scene, has_buried=False)
    assert "'b', 'c', 'd' and 1 more (0.8 of the area)" in line
    corners = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)], dtype=float)
    faces = corners[[(0, 1, 2, 2), (0, 3, 1, 1), (0, 2, 3, 3), (1, 3, 2, 2)]]
    line, = not_computed(scene_of((faces, GREY, {"smooth": True}), background=SKY), has_buried=False)
    assert "in steps of up to 2.8;" in line


@pytest.mark.parametrize("is_curved", [False, True])
def test_the_summary_names_curved_bodies_that_enter_others(is_curved):
    ball = [(sphere((2, 1.5, 0.5), 0.4, segments=8), GREY, {"smooth": True})] * is_curved
    scene = scene_of((CEILING, GREY), (box((1, 1, -1), (2, 2, 1)), GREY), *ball, background=SKY)
    stats = picture(scene, looking((3, 3, 4), (1, 1, 0)), max_edge=0.5).stats
    line = ("light along the lines where curved bodies enter others: it is too dark within an element of them; a "
            "smaller --max-edge, or bodies that end where they meet others, helps")
    assert (line in stats["not_computed"]) == is_curved
    assert ("\nnot computed: light along the lines" in summary(stats)) == is_curved
