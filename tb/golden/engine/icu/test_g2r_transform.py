import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.lib.fixed import SignalOverflowError
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from tb.golden.engine.icu.patches import CONFIG, hemisphere, screen

NUMBERS = CONFIG.numbers
CUBE = GCoordinates(corner=np.zeros(3), scale=1.0, numbers=NUMBERS, bounds=np.array([[0.0] * 3, [0.999] * 3]))


def test_a_vertex_is_rounded_once():
    scene = builtin_scene("lobby")
    geometry = PatchGeometry.of(scene, NUMBERS)
    record = hemisphere_record(Hemisphere(64, 16), geometry.coordinates, scene.bounds.mean(axis=0), (3, -1, 2))
    exact = (geometry.vertices - record.origin).astype(object) @ record.matrix.T.astype(object)
    assert np.abs(g2r_transform(record, geometry.vertices) * 2**18 - exact).max() <= 2**17


def test_opposite_offsets_give_opposite_vertices():
    record = hemisphere(64, 16)
    offset = np.random.default_rng(1).integers(-(2**23), 2**23, (1000, 3))
    there, back = (g2r_transform(record, record.origin + side * offset) for side in (1, -1))
    assert (there == -back).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_longest_offsets_fit_in_any_attitude(seed):
    # The cube's diagonal along an axis of the R frame is the worst case: sqrt 3 of 2.
    random = np.random.default_rng(seed)
    normal = random.choice([-1, 1], 3) if seed % 2 else random.normal(size=3)
    corner = random.integers(0, 2, 3) * (2**24 - 1)
    towards = hemisphere_record(Hemisphere(4, 4), CUBE, corner / 2**24, normal)
    corners = np.stack(np.meshgrid(*[[0, 2**24 - 1]] * 3), axis=-1).reshape(-1, 3)
    vertices = g2r_transform(towards, corners)
    assert np.abs(vertices).max() <= 1.7321 * 2**22
    assert NUMBERS.vector.high == 2**23 - 1


def test_offsets_that_cannot_be_are_an_error():
    with pytest.raises(SignalOverflowError, match=r"^vertex offset must fit signed 0\.24"):
        g2r_transform(screen(4, 4), np.array([2**25, 0, 0]))
