"""What the benchmark of growing meshes derives from what it measures."""

import numpy as np
import pytest

from benchmarks.mesh_sizes import measure_cast, relative_error, samples_of_error
from golden.cast.rays import Rays


@pytest.mark.parametrize(("error", "measured", "samples"), [
    (0.1, 0.1, 64), (0.05, 0.1, 256), (0.2, 0.1, 16), (10.0, 0.1, 1)])
def test_the_error_falls_with_the_square_root_of_the_samples(error, measured, samples):
    assert samples_of_error(error, measured, 64) == samples


def test_errors_are_relative_to_the_pixel_and_in_the_dark_to_a_hundredth_of_the_mean():
    reference = np.array([[[2.0, 2.0, 2.0], [0.0, 0.0, 0.0]]])
    assert relative_error(reference, reference) == 0
    brighter = np.add(reference, [[[0.22, 0, 0], [0, 0, 0]]])
    assert relative_error(brighter, reference) == pytest.approx(0.22 / 2.01 / np.sqrt(6))
    lit = np.add(reference, [[[0, 0, 0], [0, 0.01, 0]]])
    assert relative_error(lit, reference) == pytest.approx(1 / np.sqrt(6))


@pytest.mark.parametrize(("scene", "method", "triangles"), [
    ("furnace:2", "grid", 48), ("furnace:2", "embree", 48), ("tetra:2", "embree", 16)])
def test_a_cast_counts_two_triangles_for_a_quadrilateral(scene, method, triangles):
    rays = Rays(np.full((8, 3), 0.5), np.tile((0.1, 0.2, 1.0), (8, 1)))
    found = measure_cast(scene, method, rays, rays)
    assert found.triangles == triangles
    assert min(found.primary, found.diffuse, found.memory) > 0
