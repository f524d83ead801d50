"""Nodes have the faces whose boxes meet their regions, each once."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.screen_split import MESHES, SPLITTERS, split_screen
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights
from tb.radiosity.machines.merge.marched import small_volume

pytestmark = pytest.mark.usefixtures("interpreted")

SIZE = 32


def split(splitter, nodes=8, **keywords):
    _, screen = small_volume(2)
    return screen, split_screen(splitter, screen.boxes, TRIANGLES_ALONE, nodes=nodes, width=SIZE, height=SIZE,
                                **keywords)


@pytest.mark.parametrize("splitter", SPLITTERS)
@pytest.mark.parametrize("nodes", [1, 8])
def test_faces_are_those_whose_boxes_have_a_pixel_of_the_region(splitter, nodes):
    screen, found = split(splitter, nodes)
    # Where cells are pixels or regions are rectangles, no box is sent in vain.
    assert found.levels.shape == (nodes.bit_length(), SIZE, SIZE)
    for node in range(nodes):
        own = found.faces.face[found.faces.start[node]:found.faces.start[node + 1]]
        expected = [number for number, (left, top, right, bottom) in enumerate(screen.boxes)
                    if (found.owner[top:bottom + 1, left:right + 1] == node).any()]
        assert own.tolist() == expected


@pytest.mark.parametrize("splitter", MESHES)
def test_a_coarse_mesh_sends_boxes_to_the_owners_of_their_cells(splitter):
    screen, found = split(splitter, mesh=8)
    assert (found.owner.reshape(8, 4, 8, 4) == found.owner[::4, ::4][:, None, :, None]).all()
    for node in range(8):
        own = found.faces.face[found.faces.start[node]:found.faces.start[node + 1]]
        cells = screen.boxes // 4
        expected = [number for number, (left, top, right, bottom) in enumerate(cells)
                    if (found.owner[::4, ::4][top:bottom + 1, left:right + 1] == node).any()]
        assert own.tolist() == expected


def test_recursive_rectangles_are_balanced_at_least_as_well_as_bands():
    loads = {splitter: np.diff(split(splitter)[1].faces.start).max() for splitter in ("hs", "rrs")}
    assert loads["rrs"] <= loads["hs"]


def test_other_splitters_are_refused():
    with pytest.raises(InputError, match="Splitter must be one of hs, rs, rrs, mahd, hcs, gs, not 'quad'"):
        split("quad")


def test_weights_move_cuts():
    _, screen = small_volume(2)
    both = [split_screen("hs", screen.boxes, weights, nodes=4, width=SIZE, height=SIZE).owner
            for weights in (TRIANGLES_ALONE, WorkWeights())]
    assert not np.array_equal(*both)
