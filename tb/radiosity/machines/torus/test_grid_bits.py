"""Bits screen the chains of a hash table, and the voxels of a node are its own box's."""

import numpy as np
import pytest

from radiosity.machines.torus.columns import Walk
from radiosity.machines.torus.grid_walk import EXIT, walk
from radiosity.machines.torus.node_boxes import node_boxes
from radiosity.machines.torus.node_grids import node_grids
from radiosity.machines.torus.torus_run import TorusSetup
from tb.radiosity.machines.torus.torus_cases import drawn_scene

pytestmark = pytest.mark.usefixtures("interpreted")


def test_a_chain_is_read_where_the_voxel_s_bit_is_set_alone():
    """Every voxel has the same chain, in which one voxel alone has an entry."""
    scene = drawn_scene(3, spheres=1, polygons=0)
    boxes = node_boxes(scene, side=1, size=(8, 8))
    grids = node_grids(scene.objects, scene.bounds, boxes, subdivisions=6, entries=1)
    assert len(grids.references) > 1
    # Without bits of its own no voxel is full, but those of the shell.
    empty = node_grids(scene.objects, scene.bounds + 1e6, boxes, subdivisions=6, entries=1)
    grids, counts = grids._replace(bits=empty.bits), np.zeros(len(Walk), dtype=np.int64)
    origin, direction = grids.low[0] + 3.5 * grids.cell[0], np.array([1.0, 0.0, 0.0])
    ended = walk(grids, scene.objects, 0, origin, direction, 0.0, np.inf, np.zeros(1, dtype=np.int64), 1, counts)
    assert ended[:2] == (EXIT, 0)
    # The shell voxel at the end searches the chain, in vain.
    assert counts[Walk.CHAINED] == len(grids.references)


def test_smaller_boxes_have_finer_voxels():
    scene = drawn_scene(5)
    boxes = node_boxes(scene, side=3, size=(21, 21))
    grids = node_grids(scene.objects, scene.bounds, boxes, subdivisions=8)
    assert grids.cell == pytest.approx((boxes.grown[:, 1] - boxes.grown[:, 0]) / 8)
    # The node in the middle has the smallest box: outer ones have the space beside the picture.
    assert (grids.cell[4, :2] < grids.cell[[0, 2, 6, 8], :2]).all()


def test_boxes_grow_by_two_percent_by_default():
    scene = drawn_scene(5)
    plain, grown = (node_boxes(scene, side=3, size=(21, 21), **growth) for growth in (
        {"growth": 0.0}, {"growth": TorusSetup().growth}))
    sizes = [one.grown[4, 1, :2] - one.grown[4, 0, :2] for one in (plain, grown)]
    assert sizes[1] == pytest.approx(1.02 * sizes[0])
