"""Compiled and as it is, the arithmetic of pairs gives the same bits."""

import numpy as np
import pytest

from golden.light.factors import pair_factors, pair_kernel
from golden.light.factors.rows import FactorRows
from golden.light.factors.sides import Sides
from golden.scene.builtin import builtin_scene
from tb.golden.light.cube import cube
from tb.golden.light.factors.on_arrays import on_arrays
from tb.golden.light.factors.plates import plates


def candidates_on_arrays(sides, rows, limit, all_pairs):
    """All pairs of rows and columns at once."""
    column, own = np.arange(len(sides)), (slice(None), None)
    (dx, dy, dz), (nx, ny, nz) = sides.centre.T[:, None] - sides.centre[rows].T[..., None], sides.normal.T
    mx, my, mz = nx[rows][own], ny[rows][own], nz[rows][own]
    radius, area = sides.radius[rows][own], sides.area[rows][own]
    gap = np.sqrt(dx * dx + dy * dy + dz * dz) - sides.radius - radius
    over_row = (dx * mx + dy * my + dz * mz) + sides.radius
    over_column = radius - (dx * nx + dy * ny + dz * nz)
    large = sides.area * np.minimum(over_row, gap) * np.minimum(over_column, gap) > (
        limit * np.pi * (gap * gap) * (gap * gap))
    excess = sides.area / area - 1
    odd = ((rows[own] + column) % 2 == 0) == (rows[own] < column)
    measures = (excess > 1e-9) | ((np.abs(excess) <= 1e-9) & odd) | all_pairs
    found, others = np.nonzero(measures & (over_row > 0) & (over_column > 0) & (large | (gap <= 0)))
    return rows[found], others


@pytest.mark.parametrize(("scene", "step", "all_pairs"), [
    (builtin_scene("lobby"), 5, False), (builtin_scene("city:1"), 20, False), (plates(), 1, True), (cube(2), 2, True)],
    ids=["lobby", "city", "plates", "cube"])
def test_both_have_the_same_bits(scene, step, all_pairs, monkeypatch):
    sides, numbers = Sides(scene), np.arange(0, len(scene), step)
    # No ray is cast.
    row, column = FactorRows(scene, None, error=1e-3)._candidates(numbers, 5e-4, all_pairs)
    vertices = np.concatenate([scene.vertices, scene.vertices[:, ::-1]])
    # One of many pairs: without the compiler each takes a millisecond.
    some = np.arange(0, len(row), max(1, len(row) // 400))
    pairs = vertices[row[some]], vertices[column[some]]
    areas = pair_factors.exchange_areas(*pairs)
    assert len(row) > 0
    on_arrays(monkeypatch, pair_kernel)
    for compiled, plain in zip((row, column), candidates_on_arrays(sides, numbers, 5e-4, all_pairs), strict=True):
        assert compiled.tobytes() == plain.tobytes()
    monkeypatch.setattr(pair_factors, "exchange_of_far", pair_kernel.exchange_of_far)
    assert areas.tobytes() == pair_factors.exchange_areas(*pairs).tobytes()
