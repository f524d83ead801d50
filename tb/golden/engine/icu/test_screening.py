import numpy as np
import pytest

from golden.engine.icu.plane_factor import plane_factor
from golden.engine.icu.screening import cones, edge_distances, inside, inside_cones
from tb.golden.engine.icu.meshes import MESHES, aimed_directions, mesh_around, random_directions
from tb.golden.engine.icu.patches import CONFIG, KINDS, brute_hits, hard_patches, hemisphere, setup


def lost(name, seed, count, aimed):
    vertices = mesh_around(name, seed)
    assert not plane_factor(vertices, CONFIG.numbers).dropped.any()
    directions = aimed_directions(vertices, seed, count) if aimed else random_directions(seed, count)
    return np.count_nonzero(brute_hits(setup(vertices)[1], directions) == 0)


@pytest.mark.parametrize("aimed", [False, True], ids=["random", "at vertices and edges"])
@pytest.mark.parametrize("name", MESHES)
def test_a_watertight_mesh_loses_no_ray(name, aimed):
    assert [lost(name, seed, 4000, aimed) for seed in range(2)] == [0, 0]


@pytest.mark.nightly
@pytest.mark.parametrize("aimed", [False, True], ids=["random", "at vertices and edges"])
@pytest.mark.parametrize("name", MESHES)
def test_a_watertight_mesh_loses_none_of_a_million_rays(name, aimed):
    assert [lost(name, seed, 50_000, aimed) for seed in range(100, 120)] == [0] * 20


@pytest.mark.parametrize("kind", KINDS)
def test_cones_and_pairs_are_the_same_test(kind):
    vertices, directions = hard_patches(kind, 8, 60), hemisphere(32, 16).all_directions()
    planes = setup(vertices)[1]
    patch, ray = (grid.ravel() for grid in np.meshgrid(np.arange(60), np.arange(len(directions)), indexing="ij"))
    pairs, _ = inside(edge_distances(planes[patch], directions[ray], CONFIG.numbers), planes[patch])
    owner, turned = cones(planes)
    cone, met = inside_cones(turned, directions)
    by_cones = np.zeros((60, len(directions)), dtype=bool)
    by_cones[owner[cone], met] = True
    assert (pairs.reshape(60, -1) == by_cones).all()


def test_a_convex_quad_is_the_union_of_its_triangles():
    vertices, directions = hard_patches("anywhere", 9, 300), hemisphere(64, 32).all_directions()
    quads = setup(vertices)[1]
    one, two = (setup(vertices[:, corners])[1] for corners in ([0, 1, 2, 2], [0, 2, 3, 3]))
    for row in range(0, len(directions), 64):
        block = directions[row:row + 64]
        patch, ray = (grid.ravel() for grid in np.meshgrid(np.arange(300), np.arange(64), indexing="ij"))
        held = [inside(edge_distances(planes[patch], block[ray], CONFIG.numbers), planes[patch])[0]
                for planes in (quads, one, two)]
        assert (held[0] == held[1] | held[2]).all()
