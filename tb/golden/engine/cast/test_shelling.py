"""Shelling is bit-exact with brute force in fixed point, each margin is necessary, and its work is as stated."""

import numpy as np
import pytest

from golden.cast.default_camera import default_camera
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.cast.shared_caster import shared_caster
from golden.engine.cast.fixed_hits import read_out
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.ctu import grid_rays, margins
from golden.engine.ctu.sector import Sector
from golden.engine.frustum.record import hemisphere_record, screen_record
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.subshells import SubshellList
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.scene import Scene
from tb.golden.cast.frusta import (
    CELLS,
    CONFIG,
    RandomFrustum,
    halves,
    random_frustum,
    room,
    speckled_frustum,
)
from tb.golden.cast.shutters import late_entries, shuttered


@pytest.fixture
def margin(monkeypatch):
    """Sets margins for one test."""
    def set_margins(**functions):
        for name, function in functions.items():
            monkeypatch.setattr(margins, name, function)
        grid_rays.hemisphere_rays.cache_clear()
        grid_rays.screen_rays.cache_clear()

    yield set_margins
    monkeypatch.undo()
    set_margins()


def check(frusta):
    """No frustum differs, whether cast by one cluster or several."""
    for frustum in frusta:
        expected = frustum.naive()
        for parts in 1, (2, 4, 8)[frustum.seed % 3]:
            hits, counts = frustum.shelling(sectors=halves(frustum.record, parts))
            assert len(hits.differences(expected)) == 0, f"{frustum.seed} {parts}"
            assert len(counts) == parts


def test_random_frusta_are_exact_with_any_number_of_clusters():
    check(map(random_frustum, range(18)))


def test_frusta_of_isolated_rays_are_exact_with_any_number_of_clusters():
    check(map(speckled_frustum, range(9)))


@pytest.mark.nightly
@pytest.mark.parametrize("first", range(1000, 4000, 100))
def test_many_random_frusta_are_exact(first):
    check(random_frustum(seed) for seed in range(first, first + 80))
    check(speckled_frustum(seed) for seed in range(first + 80, first + 100))


def frusta_of(name, *, cells, origins, rays=(64, 16), pixels=(40, 30), seed=0):
    """Hemispheres on patches of a built-in scene, and its own view."""
    scene = builtin_scene(name)
    random = np.random.default_rng(seed)
    patches = random.integers(len(scene), size=origins)
    points = [random.dirichlet(np.ones(4)) @ scene.vertices[patch] for patch in patches]
    camera = scene.camera or default_camera(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [*points, camera.eye])
    records = [hemisphere_record(Hemisphere(*rays), geometry.coordinates, point, scene.normals[patch],
                                 source=int(scene.surface[patch]))
               for patch, point in zip(patches, points, strict=True)]
    records.append(screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), geometry.coordinates))
    return [RandomFrustum(seed, geometry, record, cell) for record in records for cell in cells]


@pytest.mark.parametrize("name", ["cornell", "room1627", "teapot:4"])
def test_built_in_scenes_are_exact(name):
    for frustum in frusta_of(name, cells=[0.125], origins=2):
        assert frustum.differing() == 0


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["cornell", "furnace", "lobby", "room1627", "cubes", "man", "phone", "teapot", "tetra",
                                  "mountain", "rings", "balls", "gears", "tree"])
def test_all_built_in_scenes_are_exact(name):
    for frustum in frusta_of(name, cells=[0.5, 0.125, 0.0625], origins=8, rays=(128, 32), pixels=(80, 60)):
        assert frustum.differing() == 0


@pytest.mark.parametrize("seed", [6, 8])
def test_tests_are_counted_ray_by_ray(seed):
    """Those of a sector's rays are its tests: of a hemisphere and of a screen."""
    frustum = random_frustum(seed)
    sectors, tests = halves(frustum.record, 4), np.zeros(len(frustum.record), dtype=np.int64)
    _, counts = frustum.shelling(sectors=sectors, ray_tests=tests)
    assert tests.max() > 1
    assert [tests[one.mask(frustum.record).ravel()].sum() for one in sectors] == [one.tests for one in counts]


@pytest.mark.parametrize(("width", "height", "fov", "seed"), [(2, 1024, 40, 0), (1, 700, 60, 1), (600, 4, 0.3, 2)])
def test_elongated_screens_are_exact_and_their_rays_are_the_cameras(width, height, fov, seed):
    """In small triangles near the plane of a strip."""
    random, eye = np.random.default_rng(seed), (0.31, -0.7, 0.5)
    up = (1, 0, 0) if height > width else (0, 0, 1)
    middle = random.random((3000, 1, 3)) * (1, 1, 0.002) + (0, 0, 0.499)
    scene = Scene.from_arrays(middle + 0.01 * (random.random((3000, 3, 3)) - 0.5), name="strip")
    screen = Screen(camera=Camera(eye=eye, target=(0.43, 1, 0.5), up=up, fov=fov), width=width, height=height)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [eye])
    frustum = RandomFrustum(seed, geometry, screen_record(screen, geometry.coordinates), 1 / 64)
    naive = frustum.naive()
    assert len(frustum.shelling()[0].differences(naive)) == 0
    other = naive.patch != shared_caster(scene, "grid", 1).nearest(screen.rays()).patch
    assert np.count_nonzero(naive.patch >= 0) > 0.5 * len(screen)
    assert np.count_nonzero(other) < 0.02 * len(screen)


@pytest.mark.parametrize(("fov", "cell"), [(0.12, 1 / 128), (0.3, 1 / 256), (1.0, 1 / 256)])
def test_narrow_screens_are_exact(fov, cell):
    """A slanted quad that fills the view from afar, and small squares up to two cells before it."""
    random, middle = np.random.default_rng(3), np.full(3, 0.5)
    half, corners = np.tan(np.radians(fov / 2)), np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])

    def seen(direction):
        camera = Camera(eye=tuple(middle - 4 * direction), target=tuple(middle), up=(0, 0, 1), fov=fov)
        return Screen(camera=camera, width=128, height=128)

    def shallowest(direction):
        """How much less than `z_scale` the R coordinate of depth 1 is."""
        screen = seen(direction)
        record = screen_record(screen, GCoordinates.of(room(), CONFIG.numbers, [screen.camera.eye]))
        return record.z_scale - record.matrix[2] @ screen.camera.axes[2]

    axes = random.normal(size=(400, 3))
    screen = seen(max(axes / np.linalg.norm(axes, axis=1, keepdims=True), key=shallowest))
    across, forward = screen.camera.axes[:2], screen.camera.axes[2]
    place, before = random.uniform(-3, 3, (400, 1, 2)) * half, random.uniform(0.5, 2, (400, 1)) * cell
    flat = np.concatenate([corners[None] * 5.2 * half, place + 0.4 * cell * corners])
    depth = np.concatenate([flat[:1, :, 0], place[..., 0] - before + np.zeros(4)])
    patches = middle + flat @ across + depth[..., None] * forward
    box = np.array([[0, 0, 0], [1e-4, 0, 0], [1e-4, 1e-4, 0], [0, 1e-4, 0]])
    scene = Scene.from_arrays(np.concatenate([patches, [box, 1 - box]]), name="tele")
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [screen.camera.eye])
    frustum = RandomFrustum(0, geometry, screen_record(screen, geometry.coordinates), cell)
    assert np.count_nonzero(frustum.naive().patch > 0) > 1000
    assert frustum.differing() == 0


def test_the_order_of_the_patches_does_not_matter():
    frustum = random_frustum(6)
    expected = frustum.naive()
    for seed in range(2):
        order = np.random.default_rng(seed).permutation(len(frustum.geometry))
        hits, _ = Shelling(frustum.geometry[order], CONFIG, cell=frustum.cell).cast(frustum.record)
        np.testing.assert_array_equal(hits.inverse, expected.inverse)
        # Where two patches are equally near the smaller number wins, which is another patch in another order.
        alone = hits.patch >= 0
        same = order[hits.patch[alone]] == expected.patch[alone]
        assert same.mean() > 0.9
        assert len(hits.differences(NaiveFixed(frustum.geometry[order], CONFIG).cast(frustum.record))) == 0


def test_subshells_change_the_order_only():
    random, more = np.random.default_rng(8), False
    for frustum in [*map(random_frustum, range(4)), *frusta_of("room1627", cells=[0.125], origins=1)]:
        window = PatchSetup(frustum.record, CONFIG).patches(frustum.geometry).window
        patches = random.permutation(np.argsort(window.rays % (len(frustum.record) // 3))[-6:])
        subshells = SubshellList(patches, random.integers(1, 20, 6))
        hits, (count,) = frustum.shelling(subshells=(subshells,))
        plain, (expected,) = frustum.shelling()
        assert len(hits.differences(plain)) == 0
        assert count.patches <= len(frustum.geometry)
        more |= count.grid_rays > expected.grid_rays
    # Depth first, a subshell's grid rays lack hits that breadth first would have found.
    assert more


@pytest.mark.parametrize("make", [random_frustum, speckled_frustum])
def test_settle_codes_open_more_cells_and_the_hits_are_the_same(make):
    coarse = CONFIG.replace({"icu.tile_bits": 3, "icu.settle_bits": 6, "icu.settle_fraction": 3})
    more = 0
    for frustum in map(make, range(3)):
        sectors = halves(frustum.record, (1, 4)[frustum.seed % 2])
        hits, plain = frustum.shelling(sectors=sectors)
        for config in CONFIG, coarse:
            same, counts = frustum.shelling(by_code=True, config=config, sectors=sectors)
            assert len(hits.differences(same)) == 0, frustum.seed
            for exact, coded in zip(plain, counts, strict=True):
                assert coded.cells >= exact.cells
                assert coded.grid_rays >= exact.grid_rays
                more += coded.grid_rays > exact.grid_rays
    assert more


def test_survival_by_old_codes_opens_more_cells_and_the_hits_are_the_same():
    random, more = np.random.default_rng(9), 0
    for frustum in [*map(random_frustum, range(2)), *map(speckled_frustum, range(2))]:
        expected, (plain,) = frustum.shelling(by_code=True)
        shelling = Shelling(frustum.geometry, CONFIG, cell=frustum.cell, by_code=True)
        memory, counts = RayMemory(len(frustum.record), CONFIG), ShellingCounts()
        tests, whole = shelling.tests(frustum.record, memory), Sector.whole(frustum.record)
        cluster, seen = shelling.cluster(frustum.record, whole), [memory.inverse]
        for stage_number in cluster.schedule(None, tests.window):
            stage = cluster.explore(*stage_number, seen[max(0, len(seen) - 1 - random.integers(4))])
            if stage is not None:
                tests.run(stage, whole, counts)
            seen.append(memory.inverse)
        hits = read_out(memory, frustum.record, tests.patches, CONFIG)
        assert len(hits.differences(expected)) == 0, frustum.seed
        assert counts.cells >= plain.cells
        more += counts.cells > plain.cells
    assert more


def wrong(frusta, *, parts=1):
    """Whether a frustum differs; those behind it are not cast."""
    return any(frustum.differing(sectors=halves(frustum.record, parts)) for frustum in frusta)


@pytest.fixture(scope="module")
def hemispheres():
    return [speckled_frustum(seed) for seed in range(1, 48, 2)]


@pytest.fixture(scope="module")
def screens():
    return [speckled_frustum(seed) for seed in range(0, 48, 2)]


@pytest.mark.nightly
@pytest.mark.parametrize(("frusta", "parts", "name", "replacement"), [
    ("hemispheres", 1, "angle", lambda shell, rounding: 0.0),
    ("hemispheres", 1, "horizon", lambda shell, rounding: 0.0),
    ("hemispheres", 4, "sector_angle", lambda shell, rounding: 0.0),
    ("screens", 1, "depth", lambda shell, rounding: 0.0),
    ("screens", 4, "screen_sector_reach", lambda shell, half, step, slope_scale, rounding: 0.0),
    ("screens", 1, "screen_border", lambda shell, half, slope_scale, rounding: 0.0),
    ("screens", 1, "screen_reach", lambda shell, half, step, slope_scale, rounding: step / 2)],
    ids=lambda value: value if isinstance(value, str) else "")
def test_without_a_margin_hits_are_lost(margin, request, frusta, parts, name, replacement):
    """Each is necessary; that each is as derived, and where it has to be, is in `tb.golden.engine.ctu.test_margins`."""
    margin(**{name: replacement})
    assert wrong(request.getfixturevalue(frusta), parts=parts)


def directed(seeds, rows, count):
    """Scenes in which one ray has a patch in a cell that, with the present margins, no grid ray opens."""
    found = []
    for seed in seeds:
        random = np.random.default_rng(seed)
        origin, normal = random.uniform(6, 10, 3), random.normal(size=3)
        normal /= np.linalg.norm(normal)
        coordinates = GCoordinates.of(room(), CONFIG.numbers, [origin])
        record = hemisphere_record(Hemisphere(64, 16), coordinates, origin, normal)
        table = CellTable(coordinates.integers(room().vertices), cell=coordinates.cell_size(1 / CELLS))
        for ray in random.choice(rows * 64, 40, replace=False):
            direction = record.all_directions()[ray] @ record.to_global.T / 2.0**32
            direction /= np.linalg.norm(direction)
            for distance in late_entries(record, table, int(ray)):
                if np.abs(origin + distance * direction - CELLS / 2).max() > CELLS / 2 - 0.2:
                    continue
                scene = shuttered(frame(normal), origin, direction, distance=distance)
                found.append(RandomFrustum(seed, PatchGeometry.of(scene, CONFIG.numbers, [origin]), record, 1 / CELLS))
                if len(found) == count:
                    return found
    return found


def check_directed(margin, *, rows, count, seeds=range(8), **functions):
    """Scenes directed against these margins differ without them, and only then."""
    margin(**functions)
    frusta = directed(seeds, rows, count)
    assert len(frusta) == count
    assert all(frustum.differing() for frustum in frusta)
    margin(**{name: ORIGINAL[name] for name in functions})
    assert not wrong(frusta)


ORIGINAL = {name: getattr(margins, name) for name in ("angle", "depth", "azimuth_reach")}


@pytest.mark.nightly
def test_without_the_depth_directed_scenes_go_wrong(margin):
    check_directed(margin, rows=10, count=3, depth=lambda shell, rounding: 0.0)


@pytest.mark.nightly
@pytest.mark.parametrize(("step", "rows", "count", "seeds"), [(0.75, 10, 3, range(8)), (1.0, 12, 1, [59])])
def test_with_one_step_instead_of_the_angle_directed_scenes_go_wrong(margin, step, rows, count, seeds):
    check_directed(margin, rows=rows, count=count, seeds=seeds,
                   angle=lambda shell, rounding: step * grid_rays.steps(shell, rounding)[1] if shell > 2
                   else ORIGINAL["angle"](shell, rounding))


@pytest.mark.nightly
def test_with_two_azimuth_steps_near_the_pole_directed_scenes_go_wrong(margin):
    def two_steps(psi, polar):
        if psi > np.pi / 2:
            return ORIGINAL["azimuth_reach"](psi, polar)
        shell = 1 + (margins.DIAGONAL + margins.RADIUS) / np.sin(psi)
        return np.full(np.shape(polar), 2 * grid_rays.steps(shell)[0])

    check_directed(margin, rows=2, count=3, azimuth_reach=two_steps)


@pytest.mark.nightly
def test_the_directed_scenes_end_with_the_margins_as_they_are():
    assert directed(range(2), 10, 1) == []


@pytest.mark.parametrize(("name", "tests_per_ray"), [
    pytest.param("lobby", 2.6, marks=pytest.mark.nightly), ("room1627", 3.3)])
def test_work_per_ray_from_the_ceiling(name, tests_per_ray):
    scene = builtin_scene(name)
    lower, upper = scene.bounds
    shares = (np.arange(4) + 0.5) / 4
    origins = [lower + (upper - lower) * (x, y, 1 - 1e-3) for x in shares for y in shares]
    geometry = PatchGeometry.of(scene, CONFIG.numbers, origins)
    shelling = Shelling(geometry, CONFIG, cell=0.0625)
    total = ShellingCounts()
    for origin in origins:
        _, (counts,) = shelling.cast(hemisphere_record(Hemisphere(256, 64), geometry.coordinates, origin, (0, 0, -1)))
        assert counts.patches <= len(scene)
        total += counts
    assert total.tests / total.rays <= tests_per_ray
    assert total.cell_steps / total.rays <= 3.2
    assert total.tests <= total.in_windows
