import numpy as np
import pytest

from golden.scene.builtin.tetra import pyramid, tetra
from tb.golden.scene.closed import assert_closed


@pytest.mark.parametrize(("levels", "count"), [(1, 4), (2, 16), (3, 64), (6, 4096)])
def test_pyramid_has_the_published_number_of_triangles(levels, count):
    assert len(pyramid(levels)) == count
    assert len(tetra(levels)) == count


def test_triangles_are_equal_and_their_tetrahedra_closed():
    scene = tetra(4)
    assert scene.areas == pytest.approx(scene.areas[0], rel=1e-12)
    for tetrahedron in scene.vertices.reshape(-1, 4, 4, 3):
        assert_closed(tetrahedron)
        outward = tetrahedron.mean(axis=1) - tetrahedron.mean(axis=(0, 1))
        vectors = np.cross(tetrahedron[:, 1] - tetrahedron[:, 0], tetrahedron[:, 2] - tetrahedron[:, 0])
        assert (outward * vectors).sum(axis=1).min() > 0


def test_tetrahedra_meet_in_equal_corners():
    """The 4-sided Sierpinski pyramid of n levels has 2 (4^(n-1) + 1) corners."""
    for levels in (2, 3, 5):
        assert len(np.unique(tetra(levels).vertices.reshape(-1, 3), axis=0)) == 2 * (4 ** (levels - 1) + 1)


def test_pyramid_stands_upright_on_its_base():
    points = np.unique(tetra(3).vertices.reshape(-1, 3), axis=0)
    top = points[points[:, 2] == points[:, 2].max()]
    assert len(top) == 1
    assert top[0, :2] == pytest.approx((0, 0), abs=1e-12)
