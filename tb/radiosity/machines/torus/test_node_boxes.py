"""Boxes divide space along the rays through the corners of pixels, and grow by a share of an axis or of the volume."""

import numpy as np
import pytest

from radiosity.machines.torus.node_boxes import front_face, node_boxes
from radiosity.machines.torus.torus_scene import TorusScene
from tb.radiosity.machines.torus.torus_cases import drawn_scene

pytestmark = pytest.mark.usefixtures("interpreted")


def boxes_of(side=3, **changes):
    return node_boxes(drawn_scene(1), side=side, size=(24, 24), **changes)


def test_boxes_share_faces_cover_the_objects_and_have_the_whole_depth():
    boxes, bounds = boxes_of(), drawn_scene(1).bounds
    inner = boxes.inner.reshape(3, 3, 2, 3)
    assert (inner[:, :-1, 1, 0] == inner[:, 1:, 0, 0]).all()
    assert (inner[:-1, :, 1, 1] == inner[1:, :, 0, 1]).all()
    assert (inner[0, 0, 0] <= bounds[:, 0].min(axis=0)).all()
    assert (inner[2, 2, 1] >= bounds[:, 1].max(axis=0)).all()
    assert len(set(boxes.inner[:, 0, 2])) == len(set(boxes.inner[:, 1, 2])) == 1


def test_outer_boxes_are_larger_since_they_have_the_space_beside_the_picture():
    widths = np.diff(boxes_of().inner[:, :, 0], axis=1)[:3, 0]
    assert widths[1] < min(widths[0], widths[2])
    # A third of the picture at the front.
    assert widths[1] == pytest.approx(2 * 0.35 * boxes_of().front / 3)


@pytest.mark.parametrize("growth", [0.02, 0.24, 1.0])
def test_growth_is_a_share_of_each_axis_or_of_the_volume(growth):
    for by, expected in (("axis", 1 + growth), ("volume", (1 + growth) ** 0.5)):
        boxes = boxes_of(side=2, growth=growth, growth_by=by)
        ratio = np.diff(boxes.grown, axis=1)[:, 0] / np.diff(boxes.inner, axis=1)[:, 0]
        assert ratio[:, :2] == pytest.approx(expected, rel=0.3)
        assert (ratio[:, 2] == 1).all()
    middle = boxes_of(growth=growth).grown[4, :, 0]
    assert np.diff(middle)[0] / np.diff(boxes_of().inner[4, :, 0])[0] == pytest.approx(1 + growth)


def test_a_box_does_not_grow_beyond_its_neighbour():
    boxes = boxes_of(growth=50.0)
    grown, inner = boxes.grown.reshape(3, 3, 2, 3), boxes.inner.reshape(3, 3, 2, 3)
    assert (grown[:, 0, 1, 0] == inner[:, 1, 1, 0]).all()
    assert (grown[2, :, 0, 1] == inner[1, :, 0, 1]).all()


def test_the_front_is_that_of_space_or_of_the_nearest_object_in_view():
    scene = drawn_scene(1)
    assert front_face(scene, 1.0) == scene.bounds[:, 0, 2].min()
    # A floor under the eye and behind it enters the view at the lower edge of the picture.
    floor = np.array([[(-9, -1, -9), (9, -1, -9), (9, -1, 9), (-9, -1, 9)]], dtype=float)
    inside = TorusScene(name="floor", corners=floor, counts=[4], coefficients=np.zeros((1, 13)),
                        lights=np.zeros((0, 7)), slope=0.5)
    assert front_face(inside, 1.0) == pytest.approx(2)
