import itertools

import numpy as np

from golden.engine.icu.edge_planes import EDGES, edge_planes
from golden.engine.icu.screening import edge_distances
from tb.golden.engine.icu.patches import CONFIG, KINDS, hard_patches, setup

NUMBERS = CONFIG.numbers
TOP = 2**17 - 1


def all_kinds():
    return np.concatenate([hard_patches(kind, 2, 200) for kind in KINDS])


def test_planes_are_exact_and_antisymmetric():
    directions, planes = setup(all_kinds())
    exact = directions.astype(object)
    for number, (i, j) in enumerate(EDGES):
        a, b = exact[:, i], exact[:, j]
        for k in range(3):
            x, y = (k + 1) % 3, (k + 2) % 3
            assert (planes.planes[:, number, k] == a[:, x] * b[:, y] - a[:, y] * b[:, x]).all()
    swapped = edge_planes(directions[:, ::-1], NUMBERS)
    assert (swapped.planes[:, 0] == -planes.planes[:, 2]).all()


def test_the_largest_planes_and_distances_fit_and_need_their_widths():
    corners = np.array(list(itertools.product((-TOP, 0, TOP), repeat=3)))
    quads = corners[np.random.default_rng(1).integers(len(corners), size=(4000, 4))]
    planes = edge_planes(quads, NUMBERS)
    assert np.abs(planes.planes).max() == 2 * TOP**2 > NUMBERS.edge_plane.high // 2
    longest = np.broadcast_to(np.array([2**16, -(2**16), 2**16]), (4000, 3))
    distances = edge_distances(planes, longest, NUMBERS)
    assert np.abs(distances).max() < 2**53


def test_orientation_is_the_sign_of_the_determinants():
    directions, planes = setup(all_kinds())
    for which, corners in enumerate(([0, 1, 2], [0, 2, 3])):
        a, b, c = (directions[:, corner].astype(object) for corner in corners)
        determinant = sum(a[:, i] * (b[:, (i + 1) % 3] * c[:, (i + 2) % 3] - b[:, (i + 2) % 3] * c[:, (i + 1) % 3])
                          for i in range(3))
        assert (planes.orientation[:, which] == np.sign(determinant.astype(float))).all()


def test_triangles_are_never_split_and_have_no_second_orientation():
    directions, planes = setup(all_kinds())
    triangle = (directions[:, 2] == directions[:, 3]).all(axis=1)
    assert triangle.sum() > 100
    assert not planes.split[triangle].any()
    assert (planes.orientation[triangle, 1] == 0).all()


def test_only_what_is_strictly_convex_stays_whole():
    quads = np.array([[[-9, -9, 9], [9, -9, 9], [9, 9, 9], [-9, 9, 9]],
                      [[-9, -9, 9], [9, -9, 9], [-8, -8, 9], [-9, 9, 9]],
                      [[-9, -9, 9], [0, -9, 9], [9, -9, 9], [9, 9, 9]],
                      [[-9, -9, 9], [9, 9, 9], [9, -9, 9], [-9, 9, 9]]]) * 2**12
    assert edge_planes(quads, NUMBERS).split.tolist() == [False, True, True, True]
