"""Compiled and on arrays, the arithmetic of pairs gives the same bits."""

import numpy as np
import pytest

from golden.light.factors import pair_factors, pair_kernel, rows
from golden.light.factors.rows import FactorRows
from golden.scene.builtin import builtin_scene
from tb.golden.light.cube import cube
from tb.golden.light.factors.on_arrays import on_arrays
from tb.golden.light.factors.plates import plates


@pytest.mark.parametrize(("scene", "step", "all_pairs"), [
    (builtin_scene("lobby"), 5, False), (builtin_scene("city:1"), 20, False), (plates(), 1, True), (cube(2), 2, True)],
    ids=["lobby", "city", "plates", "cube"])
def test_both_have_the_same_bits(scene, step, all_pairs, monkeypatch):
    # No ray is cast.
    sides, numbers = FactorRows(scene, None, error=1e-3), np.arange(0, len(scene), step)
    vertices = np.concatenate([scene.vertices, scene.vertices[:, ::-1]])
    found = []
    for modules in ((), (pair_kernel, pair_factors, rows)):
        on_arrays(monkeypatch, *modules)
        row, column = sides._candidates(numbers, 5e-4, all_pairs)
        found.append((row, column, pair_factors.exchange_areas(vertices[row], vertices[column])))
    assert len(found[0][0]) > 0
    for compiled, plain in zip(*found, strict=True):
        assert compiled.tobytes() == plain.tobytes()
