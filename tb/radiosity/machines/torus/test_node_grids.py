"""Voxels have the objects whose surface meets them, as an array and as a hash table."""

import numpy as np
import pytest

from radiosity.machines.torus.columns import Grid, Reference
from radiosity.machines.torus.node_boxes import node_boxes
from radiosity.machines.torus.node_grids import node_grids
from radiosity.machines.torus.object_tests import meets_box
from radiosity.machines.torus.torus_scenes import barroom367
from tb.radiosity.machines.torus.torus_cases import drawn_scene

pytestmark = pytest.mark.usefixtures("interpreted")


def grids_of(scene, *, v=6, entries=0, side=2):
    boxes = node_boxes(scene, side=side, size=(20, 20), growth=0.1)
    return node_grids(scene.objects, scene.bounds, boxes, subdivisions=v, entries=entries)


def members(grids, node, v):
    """Objects of each inner voxel, by its index."""
    side, found = v + 2, {}
    for x, y, z in np.ndindex(v, v, v):
        index = ((x + 1) * side + y + 1) * side + z + 1
        entries = grids.shape[node, Grid.ENTRIES]
        at = grids.table[grids.shape[node, Grid.TABLE] + (index % entries if entries else index)]
        objects = []
        while at != -1:
            if not entries or grids.references[at, Reference.TAG] == index:
                objects.append(int(grids.references[at, Reference.OBJECT]))
            at = grids.references[at, Reference.NEXT]
        found[x, y, z] = objects
    return found


@pytest.mark.parametrize("entries", [0, 64, 4096])
def test_voxels_have_the_objects_whose_surface_meets_them_once(entries):
    scene, v = drawn_scene(5), 4
    grids = grids_of(scene, v=v, entries=entries)
    for node in range(4):
        for place, objects in members(grids, node, v).items():
            low = grids.low[node] + np.array(place) * grids.cell[node]
            expected = [number for number in range(len(scene))
                        if meets_box(scene.objects, number, low - 1e-9, low + grids.cell[node] + 1e-9)]
            assert sorted(objects) == expected


def test_a_node_holds_the_objects_that_meet_its_grown_box():
    scene = drawn_scene(5)
    boxes = node_boxes(scene, side=3, size=(20, 20), growth=0.1)
    grids = node_grids(scene.objects, scene.bounds, boxes, subdivisions=4)
    for node in range(9):
        expected = sum(meets_box(scene.objects, number, *boxes.grown[node]) for number in range(len(scene)))
        assert grids.held[node] == expected


def test_a_voxel_within_a_sphere_does_not_have_it():
    scene = drawn_scene(1, spheres=1, polygons=1)
    centre, radius = scene.corners[0, 0], scene.corners[0, 1, 0]
    assert not meets_box(scene.objects, 0, centre - radius / 4, centre + radius / 4)
    assert meets_box(scene.objects, 0, centre - radius / 4, centre + radius)
    assert not meets_box(scene.objects, 0, centre + radius, centre + 2 * radius)


def test_polygons_meet_boxes_as_dense_points_of_them_do():
    rng, scene = np.random.default_rng(4), drawn_scene(6, spheres=0, polygons=24)
    share = np.stack(np.meshgrid(*[np.linspace(0, 1, 60)] * 2), axis=-1).reshape(-1, 2)
    both = 0
    for number in range(24):
        one, two, three, four = scene.corners[number]
        weights = share if scene.counts[number] == 4 else share[share.sum(axis=1) <= 1]
        edges = (two - one, four - one) if scene.counts[number] == 4 else (two - one, three - one)
        points = one + weights[:, :1] * edges[0] + weights[:, 1:] * edges[1]
        for _ in range(40):
            low = points[rng.integers(len(points))] + rng.uniform(-0.4, 0.2, 3)
            high = low + rng.uniform(0.05, 0.4, 3)
            is_inside = ((points >= low) & (points <= high)).all(axis=1).any()
            met = meets_box(scene.objects, number, low, high)
            assert met or not is_inside
            # Points are a fortieth apart at most.
            near = ((points >= low - 0.03) & (points <= high + 0.03)).all(axis=1).any()
            assert near or not met
            both += met != is_inside
    assert both < 60


def test_in_an_array_voxels_that_were_empty_share_the_first_reference_of_an_object():
    scene = drawn_scene(5)
    grids = grids_of(scene)
    plain, shared, _ = grids.counts.sum(axis=0)
    assert shared > 0
    assert len(grids.references) == plain - shared
    # The tail of a list alone is shared: its next reference is none.
    assert grids_of(scene, entries=64).counts[:, 1].sum() == 0
    assert grids_of(scene, entries=64).counts[:, 0].sum() == plain


@pytest.mark.nightly
def test_the_voxel_of_a_lampshade_s_apex_keeps_its_triangles():
    grids = grids_of(barroom367(), v=41, side=1)
    lengths = [len(one) for one in members(grids, 0, 41).values()]
    assert max(lengths) >= 78
