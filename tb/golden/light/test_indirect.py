import numpy as np
import pytest
from PIL import Image
from scipy import sparse

from benchmarks.analytic import point_to_polygon
from benchmarks.closed_forms import c_11, c_14
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.light import indirect
from golden.light.direct import DirectLight
from golden.light.final_gather import FinalGather
from golden.light.indirect import indirect_light
from golden.light.preview import Preview
from golden.light.sampling import mix
from golden.light.solvers.on_demand import Shooting
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.builtin.furnace import furnace
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.refine import refine
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.golden.scene.furnaces import furnace_of, lit_from_above

SKY = 1.0, 0.5, 0.25
FLOOR = rectangle((-2, -2, 0), (4, 0, 0), (0, 4, 0))
BLOCK = box((-0.33, -0.31, 0), (0.29, 0.37, 1.2), omit=("-z",))
GREY = Material(name="grey", diffuse=(0.5, 0.5, 0.5))
UNDER_SKY = scene_of((FLOOR, BLACK), (BLOCK, BLACK), background=SKY)


def solve(scene, max_edge, *, rays=(64, 16), light_samples=16, seed=0, solver="conjugate-gradient", tally=None,
          **shooting):
    caster = Grid(scene)
    return indirect_light(scene, refine(scene, max_edge=max_edge), caster, caster, tally or Tally(),
                          hemisphere=Hemisphere(*rays), solver=solver, light_samples=light_samples, seed=seed,
                          **shooting)


def on_floor(light, x, y):
    """At points of `FLOOR`, which is patch 0."""
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    return light.at(np.zeros(x.size, dtype=int), (x.ravel() + 2) / 4, (y.ravel() + 2) / 4, np.ones(x.size, dtype=bool))


def gathered_on_floor(scene, light, x, y):
    """As a picture shows it: interpolated only where that is right."""
    points = SurfacePoints(np.stack([x, y, 0 * x], axis=1), np.tile((0.0, 0, 1), (len(x), 1)), np.zeros(len(x), int))
    return FinalGather(scene, light, Grid(scene), Tally(), 256).light(
        points, (x + 2) / 4, (y + 2) / 4, np.ones(len(x), dtype=bool), mix(0, np.arange(len(x))), np.zeros(len(x), int))


def sky_beside(block, x, y):
    """Share of the sky that points of the floor see past a block: the faces that look at a point hide theirs."""
    points = np.stack([x, y, 0 * x], axis=1)
    hidden = point_to_polygon(points, np.tile((0.0, 0, 1), (len(points), 1)), block)
    return 1 - np.maximum(hidden, 0).sum(axis=1)


@pytest.fixture
def exact_direct_light(monkeypatch):
    """Direct light in closed form, for convex rooms: what remains is the radiosity alone."""

    def irradiance(self, points, keys):
        seen = point_to_polygon(points.position, points.normal, self._scene.vertices)
        return np.maximum(seen, 0) @ self._scene.channels("emission")

    monkeypatch.setattr(DirectLight, "irradiance", irradiance)


@pytest.mark.usefixtures("exact_direct_light")
@pytest.mark.parametrize(("solver", "diffuse"), [
    ("progressive", 0.5), ("conjugate-gradient", 0.8)])
def test_every_node_of_a_furnace_gets_what_the_walls_reflect(solver, diffuse):
    """Radiosities are 1/(1 - rho), of which 1 comes straight from the walls."""
    light = solve(furnace_of(1, diffuse=diffuse), 0.34, rays=(32, 8), solver=solver)
    np.testing.assert_allclose(light.irradiance, diffuse / (1 - diffuse), rtol=1e-3)
    assert light.solution.converged
    assert not light.nodes - len(light.irradiance), "nothing changes from node to node"


@pytest.mark.usefixtures("exact_direct_light")
def test_a_cube_under_a_glowing_ceiling_has_the_known_mean_light():
    """Mean light on floor and walls for 8 x 8 patches a face; the catalogue's C-11 and C-14 are the direct part."""
    scene = lit_from_above(1)
    light = solve(scene, 0.125, rays=(32, 16))
    incident = light.elements.of_corners @ light.irradiance
    mean = np.bincount(light.elements.patch, incident[:, 0]) / 64
    np.testing.assert_allclose(mean[4] + c_11(1, 1), 0.3107, rtol=5e-3)
    np.testing.assert_allclose(mean[:4] + c_14(1, 1), 0.3283, rtol=5e-3)


def test_direct_light_is_sampled_by_shadow_rays_over_each_element():
    """A point light over a floor, which reflects it to a screen: the closed form over fine cells is the truth."""
    screen = rectangle((-2, -2, 2), (0, 4, 0), (4, 0, 0))
    scene = scene_of((FLOOR, GREY), (screen, BLACK), lights=(PointLight(position=(0.3, 0.2, 1), intensity=(1, 2, 4)),))
    light = solve(scene, 0.25, rays=(64, 16))
    centre = (np.arange(40) + 0.5) / 10 - 2
    x, y = (grid.ravel() for grid in np.meshgrid(centre, centre))
    bright = 0.5 / np.pi / ((x - 0.3) ** 2 + (y - 0.2) ** 2 + 1) ** 1.5
    cells = np.array([rectangle((a - 0.05, b - 0.05, 0), (0.1, 0, 0), (0, 0.1, 0)) for a, b in zip(x, y, strict=True)])
    spots = np.array([(0.0, 0, 2), (1, -0.7, 2), (-1.5, 1.2, 2)])
    truth = point_to_polygon(spots, np.tile((0.0, 0, -1), (3, 1)), cells) @ bright
    u, v = (spots[:, 1] + 2) / 4, (spots[:, 0] + 2) / 4
    found = light.at(np.ones(3, dtype=int), u, v, np.ones(3, dtype=bool))
    np.testing.assert_allclose(found, truth[:, None] * (1, 2, 4), rtol=0.03)
    assert not on_floor(light, spots[:, 0], spots[:, 1]).any(), "the screen is black and light sources are left out"


def test_an_open_plane_gets_exactly_the_background():
    light = solve(scene_of((FLOOR, GREY), background=SKY), 1.0)
    assert (light.irradiance == SKY).all()
    assert (on_floor(light, [-1.9, 0.3, 2.0], [0.1, -2, 2]) == SKY).all()


def test_both_sides_of_a_two_sided_sheet_have_their_own_light():
    """The upper one sees the sky alone; the lower one a black floor and the sky around it."""
    sheet = rectangle((-1, -1, 0.5), (2, 0, 0), (0, 2, 0))
    scene = scene_of((FLOOR, BLACK), (sheet, GREY, {"two_sided": True}), background=SKY)
    light = solve(scene, 0.5, rays=(128, 32))
    middle = np.array([1]), np.array([0.5]), np.array([0.5])
    np.testing.assert_allclose(light.at(*middle, np.array([True])), [SKY], rtol=1e-12)
    hidden = point_to_polygon([(0, 0, 0.5)], [(0, 0, -1)], [FLOOR])[0, 0]
    np.testing.assert_allclose(light.at(*middle, np.array([False]))[0], (1 - hidden) * np.array(SKY), rtol=0.05)


@pytest.fixture(scope="module")
def block_under_sky():
    return solve(UNDER_SKY, 0.25, rays=(128, 32))


def test_light_beside_a_block_follows_the_closed_form(block_under_sky):
    x, y = np.random.default_rng(1).uniform(-2, 2, (2, 4000))
    outside = (x < -0.33) | (x > 0.29) | (y < -0.31) | (y > 0.37)
    x, y = x[outside], y[outside]
    error = gathered_on_floor(UNDER_SKY, block_under_sky, x, y)[:, 0] - sky_beside(BLOCK, x, y)
    assert np.sqrt((error**2).mean()) < 0.01
    assert np.abs(error.mean()) < 2e-3


def test_no_dark_seam_runs_around_a_block(block_under_sky):
    """The nodes under it are inside: light is gathered beside it rather than interpolated from them."""
    x, y = np.array([(0.291, 0.0), (0.291, 0.3), (-0.331, 0.1), (0.1, 0.371), (-0.2, -0.311), (0.292, -0.312)]).T
    found = gathered_on_floor(UNDER_SKY, block_under_sky, x, y)[:, 0]
    np.testing.assert_allclose(found, sky_beside(BLOCK, x, y), rtol=0.05)


def test_nodes_inside_a_body_are_filled_from_outside(block_under_sky):
    assert block_under_sky.irradiance.min() > 0.3 * min(SKY)
    assert on_floor(block_under_sky, [0.0, 0.1], [0.0, 0.1]).min() > 0.3 * min(SKY)


def test_changes_inside_a_body_are_not_seen(block_under_sky):
    change = np.repeat(block_under_sky.buried[:, None], 3, axis=1).astype(float)
    changed = block_under_sky.changed(change, np.zeros_like(block_under_sky.refined_irradiance))
    assert change.any()
    np.testing.assert_array_equal(changed.irradiance, block_under_sky.irradiance)


def test_refinement_is_taken_where_light_changes_and_makes_it_better(monkeypatch):
    """Below a block that touches nothing."""
    block = box((-0.23, -0.21, 0.1), (0.19, 0.17, 0.4))
    scene = scene_of((FLOOR, BLACK), (block, BLACK), background=SKY)
    fine = solve(scene, 0.2, rays=(128, 32))
    chosen = np.flatnonzero(fine.sheet >= 0)
    assert 0 < len(chosen) <= len(fine.elements) / indirect.EVERY
    assert fine.nodes == len(fine.irradiance) + len(fine.refined_irradiance)
    monkeypatch.setattr(indirect, "EVERY", 10**9)
    coarse = solve(scene, 0.2, rays=(128, 32))
    assert not len(coarse.refined)
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-0.5, 0.5, 60), np.linspace(-0.5, 0.5, 60)))
    close, far = (np.abs(on_floor(light, x, y)[:, 0] - sky_beside(block, x, y)).mean() for light in (fine, coarse))
    assert close < 0.6 * far


def test_nodes_without_a_value_take_the_mean_of_known_neighbours_in_waves():
    line = sparse.diags_array([np.ones(4), np.ones(5), np.ones(4)], offsets=[-1, 0, 1]).tocsr()
    values = np.array([[6.0], [9], [9], [9], [2]])
    filled = indirect._fill(line, values, np.array([False, True, True, True, False]))
    assert filled.ravel().tolist() == [6, 6, 4, 2, 2]
    lost = indirect._fill(line, values, np.ones(5, dtype=bool))
    assert not lost.any(), "nothing is known: nothing is lit"


def test_pieces_are_uneven_by_a_share_of_the_mean_of_all():
    """Two points each: in even light, in little that differs, and in much; the mean of all is 1.2."""
    arriving = np.repeat([[3.0], [3], [0], [0.2], [0], [1]], 3, axis=1)
    means = sparse.csr_array(np.kron(np.eye(3), [[0.5, 0.5]]))
    assert indirect._uneven(means, arriving, means @ arriving).tolist() == [False, False, True]


def test_colours_do_not_mix():
    red = Material(name="red", diffuse=(0.8, 0.0, 0.0))
    wall = rectangle((-2, -2, 0), (0, 4, 0), (0, 0, 3))
    light = solve(scene_of((FLOOR, GREY), (wall, red), background=(1.0, 1.0, 0.0)), 0.5)
    near = on_floor(light, [-1.7], [0.0])[0]
    assert near[0] > near[1] + 0.1
    assert near[2] == 0


@pytest.mark.parametrize("light", [
    {"lights": (PointLight(position=(0, 0, 50), intensity=(1000, 1000, 1000)),)}, {"background": SKY},
], ids=["point light", "sky"])
def test_what_is_inside_a_body_does_not_darken_the_element_that_it_covers_in_part(light):
    """Elements of 1 x 1 under a block reflect what falls on their open quarters, as if the block were not there."""
    cover = box((-0.3, -0.3, 0), (1, 1, 0.003), omit=("-z",))
    open_, covered = (solve(scene_of((FLOOR, GREY), *more, **light), 1.0).solution.radiosity[:16, 0]
                      for more in ((), ((cover, BLACK),)))
    np.testing.assert_allclose(covered[[5, 6, 9]], open_[[5, 6, 9]], rtol=1e-2)
    assert covered[10] == 0, "all of it is covered"


@pytest.mark.usefixtures("exact_direct_light")
def test_mirrors_count_as_diffuse():
    mixed = Material(name="mixed", diffuse=(0.3,) * 3, specular=(0.2,) * 3, emission=(1,) * 3)
    light = solve(scene_of((furnace(1).vertices, mixed)), 0.5, rays=(16, 8))
    np.testing.assert_allclose(light.irradiance, 1, rtol=1e-4)


def test_seeds_count_and_equal_ones_give_equal_light():
    scene = lit_from_above(1)
    first, again, other = (solve(scene, 0.5, rays=(16, 8), seed=seed).irradiance for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_rays_are_counted():
    tally = Tally()
    light = solve(lit_from_above(1), 0.25, rays=(16, 8), light_samples=6, tally=tally)
    assert tally.kinds["hemisphere"]["rays"] == light.nodes * 128
    assert tally.kinds["hemisphere"]["hits"] == light.nodes * 128
    # Five faces of 16 elements, four points on each, two rays (6 over 4, rounded up) from each; the ceiling sees none.
    assert tally.kinds["shadow"]["rays"] == 5 * 16 * 4 * 2
    assert set(tally.seconds) == {"elements", "form factors", "direct light of elements", "solver",
                                  "adaptive refinement"}


@pytest.mark.usefixtures("exact_direct_light")
def test_rows_on_demand_give_a_furnace_the_light_of_all_rows():
    """Of a closed room no ray is lost: what is short of the mean is the light that shooting leaves out."""
    tally = Tally()
    light = solve(furnace(1), 0.34, rays=(64, 16), shooting=Shooting(tolerance=1e-3), tally=tally)
    np.testing.assert_allclose(light.pieces.area @ light.display / light.pieces.area.sum(), 1, rtol=1e-3)
    np.testing.assert_allclose(light.irradiance, 1, rtol=0.1)
    assert light.nodes == len(light.pieces)
    assert tally.kinds["hemisphere"]["rays"] == light.nodes * 1024, "a piece that shoots again casts nothing"
    assert len(light.refined_irradiance) == 0


def test_rows_on_demand_are_those_of_bright_elements():
    """A lamp above a floor, and another one below it: what no light reaches does not shoot."""
    below = rectangle((-2, -2, -1), (4, 0, 0), (0, 4, 0))
    lamp = Material(name="lamp", emission=(1, 1, 1))
    lit = scene_of((FLOOR, GREY), (rectangle((-1, -1, 1), (0, 2, 0), (2, 0, 0)), lamp))
    both = scene_of((FLOOR, GREY), (rectangle((-1, -1, 1), (0, 2, 0), (2, 0, 0)), lamp), (below, GREY))
    alone, hidden = (solve(scene, 1, shooting=Shooting(tolerance=0.01, overshoot=False)) for scene in (lit, both))
    assert hidden.nodes == alone.nodes > 0
    assert len(hidden.pieces) > len(alone.pieces)


def test_a_preview_shows_the_elements_between_the_steps(tmp_path):
    pictures, lamp = [], Material(name="lamp", emission=(1, 1, 1))
    scene = scene_of((FLOOR, GREY), (rectangle((-1, -1, 1), (0, 2, 0), (2, 0, 0)), lamp))
    screen = Screen(camera=Camera(eye=(0, -4, 3), target=(0, 0, 0), fov=40), width=8, height=6)

    class Kept(Preview):
        def _draw(self):
            super()._draw()
            pictures.append(np.asarray(Image.open(self.path)))

    preview = Kept(tmp_path / "preview.png", steps=2).of(scene, screen, Grid(scene))
    light = solve(scene, 1, shooting=Shooting(tolerance=1e-4, shooters=1), preview=preview)
    # The first state, and every second one.
    assert len(pictures) == (light.solution.steps + 1) // 2
    assert pictures[0].shape == (6, 8, 3)
    assert [path.name for path in tmp_path.iterdir()] == ["preview.png"]
    assert (pictures[-1] != pictures[0]).any()


def test_a_preview_of_one_picture_says_nothing_of_the_next_one(tmp_path):
    lamp = Material(name="lamp", emission=(1, 1, 1))
    scene = scene_of((FLOOR, GREY), (rectangle((-1, -1, 1), (0, 2, 0), (2, 0, 0)), lamp))
    path = tmp_path / "preview.png"

    def drawn(preview, eye):
        screen = Screen(camera=Camera(eye=eye, target=(0, 0, 0), fov=40), width=8, height=6)
        solve(scene, 1, shooting=Shooting(), preview=preview.of(scene, screen, Grid(scene)))
        return path.read_bytes()

    twice = Preview(path)
    before, after = drawn(twice, (0, -4, 3)), drawn(twice, (3, -5, 1))
    assert before != after == drawn(Preview(path), (3, -5, 1))
