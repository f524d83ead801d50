"""Grids are cut into five tetrahedra a cell, with as many distinct faces as the source's data sets."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.tetrahedra import blunt_fin, cut_grid

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize(("sides", "cells", "exterior", "faces"), [
    ((40, 32, 32), 187_395, 13_516, 381_548),
    pytest.param((38, 76, 38), 513_375, 27_676, 1_040_588, marks=pytest.mark.nightly)])
def test_triangles_are_the_source_s(sides, cells, exterior, faces):
    """Its numbers for blunt fin and post are 2 T + E / 2."""
    volume = blunt_fin(sides)
    assert (len(volume.cells), (volume.sides[:, 1] < 0).sum(), len(volume.faces)) == (cells, exterior, faces)


def signed(volume):
    at = volume.points[volume.cells]
    return np.einsum("ij,ij->i", np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), at[:, 3] - at[:, 0]) / 6


def test_the_cells_of_a_box_fill_it():
    axes = np.meshgrid(*(np.arange(side, dtype=float) for side in (4, 3, 5)), indexing="ij")
    volume = cut_grid(np.stack(axes, axis=-1), np.zeros((4, 3, 5)))
    assert np.abs(signed(volume)).sum() == pytest.approx(3 * 2 * 4)
    # A third of a hexahedron is its inner cell, a sixth each of the others.
    assert np.allclose(np.abs(signed(volume)).reshape(-1, 5), [1 / 3, 1 / 6, 1 / 6, 1 / 6, 1 / 6])


def test_faces_are_those_of_their_cells():
    volume = blunt_fin((5, 4, 3))
    for face, both in zip(volume.faces, volume.sides, strict=True):
        assert len(set(face)) == 3
        for cell in both[both >= 0]:
            assert set(face) <= set(volume.cells[cell])
    own = np.bincount(volume.sides[volume.sides >= 0])
    assert (own == 4).all()


@pytest.mark.parametrize("seed", range(6))
def test_no_cell_of_a_fin_is_inverted(seed):
    """All cells of one place in their hexahedron have the same orientation."""
    found = np.sign(signed(blunt_fin((12, 8, 6), seed=seed)))
    low = np.indices((11, 7, 5)).sum(axis=0).ravel() % 2
    for parity in (0, 1):
        assert (found.reshape(-1, 5)[low == parity] == found.reshape(-1, 5)[low == parity][0]).all()


def test_seeds_draw_other_fins():
    assert not np.array_equal(blunt_fin((5, 4, 3), seed=1).points, blunt_fin((5, 4, 3), seed=2).points)
    values = blunt_fin((5, 4, 3), seed=1).values
    assert values.min() >= 0
    assert values.max() <= 1


@pytest.mark.parametrize(("sides", "seed", "message"), [
    ((1, 4, 4), 0, "Grid must have 2 to 128 points along each side, not (1, 4, 4)"),
    ((4, 4, 4), -1, "Seed must be at least 0, not -1")])
def test_wrong_grids_are_refused(sides, seed, message):
    with pytest.raises(InputError) as error:
        blunt_fin(sides, seed=seed)
    assert message in str(error.value)
