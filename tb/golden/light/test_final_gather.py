"""Nodes beside a surface that is half in shadow."""

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_frusta import ShellingFrusta
from golden.light.final_gather import CHANGED, FinalGather
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.lights import PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of, solved
from tb.golden.render.pictures import looking, picture

GREY, SHADOW = 0.5, 0.13
LIGHT = np.array([1.0, 1, 3])


def shadowed_corner(*, is_curved=False, wall=BLACK):
    """A floor and a wall on its rim x = 0; a black screen halfway to the lamp shades the floor up to `SHADOW`.

    A curved wall goes on with a bend.
    """
    faces = [rectangle((0, 0, 0), (0, 2, 0), (0, 0, 1)), rectangle((0, 0, 1), (0, 2, 0), (-0.1, 0, 0.2))]
    edge = (LIGHT[0] + SHADOW) / 2
    return scene_of((rectangle((0, 0, 0), (2, 0, 0), (0, 2, 0))[None], Material(name="grey", diffuse=(GREY,) * 3)),
                    (faces[:1 + is_curved], wall, {"smooth": is_curved}),
                    (rectangle((edge - 3, -2, 1.5), (3, 0, 0), (0, 6, 0))[None], BLACK),
                    lights=(PointLight(position=tuple(LIGHT), intensity=(np.pi,) * 3),))


def from_floor(points, count=1000):
    """Irradiance over pi at points of the wall, from the part of the floor that the lamp reaches."""
    x = SHADOW + (2 - SHADOW) * (np.arange(count) + 0.5) / count
    y = 2 * (np.arange(count) + 0.5) / count
    floor = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((count, count))], axis=2)
    toward = LIGHT - floor
    radiance = GREY * toward[..., 2] / np.linalg.norm(toward, axis=2) ** 3
    found = []
    for point in points:
        along = floor - point
        found.append((radiance * along[..., 0] * -along[..., 2] / (along**2).sum(axis=2) ** 2).sum())
    return np.array(found) * (2 - SHADOW) * 2 / count**2 / np.pi


class ShadowsAlone:
    """A caster of shadow rays; no other ray is to be cast by it."""

    def __init__(self, scene):
        self.occluded, self.any_hit = Grid(scene).occluded, Grid(scene).any_hit


@pytest.mark.parametrize("by_frusta", [False, True])
def test_nodes_have_the_light_of_what_is_nearby_and_not_of_its_element(by_frusta):
    scene = shadowed_corner()
    tally, indirect = Tally(), solved(scene, 0.34)
    caster, options = (ShadowsAlone(scene), {"frusta": ShellingFrusta(scene), "together": 1}) if by_frusta else (
        Grid(scene), {})
    corrected = FinalGather(scene, indirect, caster, tally, 1024, reach=2.0, **options).corrected(0)
    for nodes, before, after in ((indirect.elements.lattice, indirect.irradiance, corrected.irradiance),
                                 (indirect.refined, indirect.refined_irradiance, corrected.refined_irradiance)):
        foot = np.flatnonzero((nodes.normal[:, 0] > 0.5) & (nodes.position[:, 2] < 0.05)
                              & (np.abs(nodes.position[:, 1] - 1) < 0.8))
        expected = from_floor(nodes.position[foot])
        whole = before[foot, 0]
        assert len(foot)
        assert (expected < 0.1 * whole).all()
        np.testing.assert_allclose(after[foot, 0], expected, rtol=0, atol=0.05 * whole.min())
    far = indirect.elements.lattice.position[:, 2] > 0.9
    np.testing.assert_array_equal(corrected.irradiance[far], indirect.irradiance[far])


def test_pictures_have_the_light_of_what_is_near_nodes():
    """At the wall's foot, and a whole element above the floor but for what is not worth a correction."""
    scene = shadowed_corner()
    found = picture(scene, looking((1, 1, 0.5), (0, 1, 0.5)), max_edge=0.34, rays=(64, 16)).indirect
    nodes = found.elements.lattice
    wall = (nodes.normal[:, 0] > 0.5) & (np.abs(nodes.position[:, 1] - 1) < 0.8)
    foot, above = (wall & (np.abs(nodes.position[:, 2] - height) < 0.05) for height in (0, 1 / 3))
    assert (found.irradiance[foot] < 0.1 * solved(scene, 0.34).irradiance[foot]).all()
    assert found.irradiance[above, 0].mean() == pytest.approx(from_floor(nodes.position[above]).mean(), rel=CHANGED)


@pytest.mark.parametrize("share", ["diffuse", "specular", "transparent"])
def test_tables_have_the_light_of_what_is_near_nodes(share):
    """What elements receive, and what they reflect of it, is that of the corrected nodes at their corners."""
    scene = shadowed_corner(wall=Material(name="wall", **{share: (0.6,) * 3}))
    indirect = solved(scene, 0.34)
    corrected = FinalGather(scene, indirect, Grid(scene), Tally(), 1024, reach=2.0).corrected(0)
    foot = (indirect.elements.normal[:, 0] > 0.5) & (indirect.elements.centre[:, 2] < 0.34)
    corners = indirect.elements.position.nodes[foot]
    change = (corrected.irradiance - indirect.irradiance)[corners].mean(axis=1)
    assert (change < -0.001).all()
    np.testing.assert_allclose((corrected.received - indirect.received)[foot], change, rtol=1e-9)
    ratio = indirect.radiosity[foot] / indirect.received[foot]
    np.testing.assert_allclose(corrected.radiosity[foot], ratio * corrected.received[foot], rtol=1e-3)


def test_nodes_of_curved_surfaces_keep_their_light():
    """Nothing but the wall looks at what the screen shades, and the wall is curved."""
    scene = shadowed_corner(is_curved=True)
    indirect = solved(scene, 0.34)
    corrected = FinalGather(scene, indirect, Grid(scene), Tally(), 1024, reach=2.0).corrected(0)
    np.testing.assert_array_equal(corrected.irradiance, indirect.irradiance)


@pytest.mark.parametrize(("samples", "error"), [(16, 0.03), (32, 0.03), (64, 0.03), (128, 0.01), (256, 0.01)])
def test_hemispheres_of_a_point_are_turned_at_random(samples, error):
    """Each is another estimate of the same light, right but for the polar angles, four or eight, and all rays are in
    frusta.
    """
    scene, tally, count = shadowed_corner(), Tally(), 100
    point, normal = np.array([[0, 1, 0.3]]), np.array([[1.0, 0, 0]])
    indirect = solved(scene, 0.34)
    gather = FinalGather(scene, indirect, ShadowsAlone(scene), tally, samples, ShellingFrusta(scene), reach=9.0,
                         together=1)
    of_pieces = indirect.rows.cast(point, normal, scene.surface[[1]], Hemisphere(256, 64)).gathered(indirect.display)
    points = SurfacePoints(*(np.repeat(row, count, axis=0) for row in (point, normal, [1])))
    found = of_pieces[0, 0] + gather.correction(points, mix(1, np.arange(count)))[:, 0]
    expected = from_floor(point)[0]
    assert 1e-3 < found.std() / expected < 0.1
    assert found.mean() == pytest.approx(expected, rel=error)
    assert tally.kinds["gather"]["rays"] == count * samples
