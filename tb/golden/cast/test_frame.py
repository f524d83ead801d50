import numpy as np
import pytest

from golden.cast.frame import frame


@pytest.fixture
def normals():
    vectors = np.random.default_rng(20).normal(size=(2000, 3))
    vectors = np.concatenate([vectors, np.eye(3), -np.eye(3), [(1, 2, 3), (-1, -2, -3)]])
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def test_frames_are_right_handed_and_end_in_the_normal(normals):
    axes = frame(normals)
    np.testing.assert_array_equal(axes[:, 2], normals)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.broadcast_to(np.eye(3), axes.shape), atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(axes), 1, atol=1e-13)


def test_frame_of_one_normal_is_that_of_many(normals):
    np.testing.assert_allclose(frame(normals[7]), frame(normals)[7], rtol=0, atol=1e-15)


def test_near_normals_have_near_frames_unless_opposite_the_pole(normals):
    moved = normals + np.random.default_rng(21).normal(scale=1e-7, size=normals.shape)
    moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    pole = np.array([1, 2, 3]) / np.sqrt(14)
    steady = np.abs(normals @ pole + 0.9) > 1e-6
    assert np.abs(frame(moved) - frame(normals))[steady].max() < 1e-5
