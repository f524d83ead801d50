import numpy as np
import pytest

from golden.cast.oracle import Oracle
from golden.engine.cast.differences import oracle_rays
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.icu.intersection import intersect
from golden.engine.icu.inverse_distance import decode
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.ray_memory import RayMemory
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from tb.golden.cast.fixed_cases import WHERE, hemisphere_in, room, screen_in, soup_case
from tb.golden.engine.icu.patches import CONFIG
from tb.golden.soups import soup


def by_windows(geometry, record, *, lazy):
    """Every patch against the rays of its window, near patches first; `lazy` skips rays that cannot improve."""
    patches = PatchSetup(record, CONFIG).patches(geometry)
    memory = RayMemory(len(record), CONFIG)
    skipped = 0
    for patch in np.argsort(-patches.bound, kind="stable"):
        _, column, row = patches.window[[patch]].pairs(record.columns)
        ray = row * record.columns + column
        keep = memory.inverse[ray] <= patches.bound[patch] if lazy else np.full(len(ray), True)
        skipped += np.count_nonzero(~keep)
        ray = ray[keep]
        hit, inverse = intersect(patches, np.full(len(ray), patch), record.directions(column[keep], row[keep]), CONFIG)
        memory.update(ray[hit], inverse, np.full(len(hit), patch))
    return memory, skipped


def assert_windows_change_nothing(geometry, record):
    naive = NaiveFixed(geometry, CONFIG).cast(record)
    for lazy in (False, True):
        memory, skipped = by_windows(geometry, record, lazy=lazy)
        assert (memory.inverse == naive.inverse).all()
        assert (memory.patch == naive.patch).all()
        assert lazy or skipped == 0


@pytest.mark.parametrize(("seed", "where"), list(enumerate(WHERE)))
def test_windows_and_lazy_isolation_change_no_hit_of_a_hemisphere(seed, where):
    _, geometry, record = soup_case(seed, where)
    assert_windows_change_nothing(geometry, record)


@pytest.mark.parametrize(("seed", "fov"), list(enumerate([1, 40, 120, 170])))
def test_windows_and_lazy_isolation_change_no_hit_of_a_screen(seed, fov):
    scene, random = soup(seed, 40), np.random.default_rng(seed)
    near = scene.vertices[5, :3].mean(axis=0) + 1e-3 * random.normal(size=3)
    geometry, record = screen_in(scene, Camera(eye=near, target=random.uniform(*scene.bounds), fov=fov))
    assert_windows_change_nothing(geometry, record)


def test_lazy_isolation_skips_tests():
    _, geometry, record = room("room1627", 1)
    _, skipped = by_windows(geometry, record, lazy=True)
    rays = PatchSetup(record, CONFIG).patches(geometry).window.rays.sum()
    assert skipped > 0.05 * rays


@pytest.mark.parametrize("seed", range(2))
def test_the_order_of_the_patches_does_not_matter(seed):
    _, geometry, record = soup_case(7, "anywhere")
    straight = NaiveFixed(geometry, CONFIG).cast(record)
    order = np.random.default_rng(seed).permutation(len(geometry))
    shuffled = NaiveFixed(geometry[order], CONFIG).cast(record)
    # Doubled patches are equally near: there the smaller of the new ids wins.
    same = np.where(shuffled.patch >= 0, order[shuffled.patch], -1) == straight.patch
    assert (shuffled.inverse == straight.inverse).all()
    doubled = (geometry.vertices[order[shuffled.patch]] == geometry.vertices[straight.patch]).all(axis=(1, 2))
    assert (same | doubled).all()
    assert (shuffled.u[same] == straight.u[same]).all()


@pytest.mark.parametrize("name", ["cornell", "lobby", "room1627", "phone"])
def test_distances_and_uv_are_the_oracles(name):
    scene, geometry, record = room(name, 3)
    fixed, rays, oracle = NaiveFixed(geometry, CONFIG).cast(record), oracle_rays(record, geometry), Oracle(scene)
    hit = np.flatnonzero(fixed.patch >= 0)
    meets, t = oracle.hits(oracle.sheared(rays), hit, fixed.patch[hit], np.full(len(hit), np.inf))
    assert len(meets) > 0.999 * len(hit)
    ray = hit[meets]
    patch = fixed.patch[ray]
    vertices = (scene.vertices[patch] - geometry.coordinates.points(record.origin)) * geometry.coordinates.scale
    distance = np.abs(np.einsum("ki,ki->k", scene.normals[patch], vertices[:, 0]))
    error = np.abs(decode(fixed.inverse[ray], CONFIG.numbers) - 1 / t)
    assert (error <= (2.0**-16 + 2.0**-21 / t) / distance + 2.0**-18 / t).all()
    u, v = oracle.uv(oracle.sheared(rays), ray, patch)
    # Patches of a few pixels have vertices in whole units: the effect on (u, v) is the ray's offset on the patch.
    side = np.sqrt(scene.areas[patch]) * geometry.coordinates.scale
    large = (side > 0.02) & ~scene.is_triangle[patch]
    off = np.maximum(np.abs(fixed.u[ray] + 0.5 - u * 256), np.abs(fixed.v[ray] + 0.5 - v * 256))[large]
    assert np.quantile(off, 0.99) < 0.55


def test_the_source_is_never_hit_and_its_neighbours_are():
    scene = builtin_scene("furnace:4")
    patch = 5
    geometry, record = hemisphere_in(scene, scene.vertices[patch].mean(axis=0), -scene.normals[patch],
                                     source=int(scene.surface[patch]))
    assert (NaiveFixed(geometry, CONFIG).cast(record).patch != patch).all()
    assert not PatchSetup(record, CONFIG).patches(geometry).live[scene.surface == scene.surface[patch]].any()
    geometry, record = hemisphere_in(scene, scene.vertices[patch].mean(axis=0), scene.normals[patch],
                                     source=int(scene.surface[patch]))
    hits = NaiveFixed(geometry, CONFIG).cast(record)
    assert (hits.patch >= 0).all()
    assert (scene.surface[hits.patch] != scene.surface[patch]).all()
