import numpy as np
import pytest

from golden.engine.cast.methods import FRUSTUM_METHODS, frustum_caster
from golden.light.form_factors import PatchRows
from golden.scene.material import Material
from golden.scene.scene import Scene

MATERIALS = tuple(Material(name=name) for name in ("red", "blue", "grey"))
# A wall between two squares that face it, of a quad and two triangles on either side, red above and blue below.
QUAD = [(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0)]
LOWER, UPPER = [(0, -1, 0), (1, -1, 0), (1, 1, 0)], [(0, -1, 0), (1, 1, 0), (0, 1, 0)]
ABOVE = [(-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)]
BELOW = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)]


def wall(order, two_sided=()):
    """Its squares first; the backs begin at another corner, and ``order`` is that of the wall's six patches."""
    fronts = [QUAD, LOWER, UPPER]
    backs = [[QUAD[k] for k in (2, 1, 0, 3)], [LOWER[k] for k in (1, 0, 2)], [UPPER[k] for k in (0, 2, 1)]]
    patches = [ABOVE, BELOW, *(([*fronts, *backs])[number] for number in order)]
    return Scene(name="wall", vertices=[[*patch, patch[-1]][:4] for patch in patches],
                 material=[2, 2, *(number // 3 for number in order)], materials=MATERIALS,
                 surface=[0, 1, *(2 for _ in order)], two_sided=[number in two_sided for number in range(-2, 6)])


@pytest.mark.parametrize("order", [(0, 1, 2, 3, 4, 5), (3, 4, 5, 0, 1, 2), (4, 0, 1, 5, 3, 2)])
@pytest.mark.parametrize("method", sorted(FRUSTUM_METHODS))
def test_of_patches_back_to_back_every_caster_hits_the_one_that_faces_the_ray(method, order):
    """From the middle of each square, four times the factor of an element to a square with a corner above it."""
    factor, scene = 4 / (np.pi * np.sqrt(2)) * np.arctan(np.sqrt(0.5)), wall(order)
    rows = PatchRows(scene, frustum_caster(scene, method), rays=(64, 32))
    factors, sums, _ = rows.cast([0, 1])
    shares = np.stack([factors.toarray()[:, scene.material == number].sum(axis=1) for number in range(3)], axis=1)
    np.testing.assert_allclose(shares, [(factor, 0, 0), (0, factor, 0)], atol=4e-3)
    # No ray meets a back, and none passes the wall.
    np.testing.assert_allclose(shares.sum(axis=1), sums[:, 0] / 2**rows.hemisphere.weight_bits, rtol=1e-12)
    back, *_ = rows.cast(np.arange(2, 8))
    assert (back.toarray()[:, 2:] == 0).all()
    np.testing.assert_array_equal(back.toarray()[:, :2] > 0, np.eye(2, dtype=bool)[scene.material[2:]])


def test_patches_that_are_two_sided_or_face_one_way_are_not_back_to_back():
    scene = wall((0, 3, 1, 4, 2, 2), two_sided=(0, 2, 3))
    upwards = np.tile([0.0, 0.0, 1.0], (len(scene), 1))
    np.testing.assert_array_equal(scene.facing(np.arange(len(scene)), upwards), np.arange(len(scene)))
    np.testing.assert_array_equal(scene.facing(np.full(len(scene), -1), upwards), np.full(len(scene), -1))
