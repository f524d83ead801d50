import numpy as np
import pytest

from golden.scene.builtin.tree import ANGLES, LENGTHS, TAPER, branches, tree


@pytest.mark.parametrize(("levels", "count"), [(0, 1), (1, 3), (2, 7), (3, 15), (11, 4095)])
def test_tree_has_the_published_number_of_branches(levels, count):
    """4095 cones, as many spheres at their ends and the field are the 8191 primitives of SPD's default size."""
    assert sum(map(len, branches(levels))) == count


def test_scene_has_a_smooth_group_for_each_cone_and_sphere():
    scene = tree(3)
    assert len(np.unique(scene.smooth)) == 15 + 15 + 2


def test_branches_start_where_their_stem_ends_and_taper():
    stems, forks = branches(4)[3:]
    pairs = forks.reshape(-1, 2, 8)
    assert np.array_equal(pairs[:, 0, :3], stems[:, 4:7])
    assert np.array_equal(pairs[:, 1, :3], stems[:, 4:7])
    assert pairs[..., 3] == pytest.approx(np.repeat(stems[:, 7:], 2, axis=1))
    assert pairs[..., 7] == pytest.approx(TAPER * pairs[..., 3])


def test_branches_bend_and_shorten_as_given():
    stems, forks = branches(5)[4:]
    stem, fork = stems[:, None, 4:7] - stems[:, None, :3], (forks[:, 4:7] - forks[:, :3]).reshape(-1, 2, 3)
    ratio = np.linalg.norm(fork, axis=2) / np.linalg.norm(stem, axis=2)
    assert ratio == pytest.approx(np.tile(LENGTHS, (len(stems), 1)))
    cosine = (stem * fork).sum(axis=2) / np.linalg.norm(stem, axis=2) / np.linalg.norm(fork, axis=2)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(np.tile(ANGLES, (len(stems), 1)))
