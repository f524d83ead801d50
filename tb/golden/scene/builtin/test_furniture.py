"""Pieces of furniture have the counts that the exact scenes are added up from."""

from itertools import pairwise

import numpy as np
import pytest

from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture
from golden.scene.material import Material

AT = (3.0, 5.0, 0.5)
CLAY = Material(name="clay", diffuse=(0.5, 0.3, 0.2))
PIECES = {
    "table": (lambda b: furniture.table(b, width=1.0, depth=0.8, at=AT), 22),
    "chair": (lambda b: furniture.chair(b, at=AT, turn=30.0), 27),
    "armchair": (lambda b: furniture.armchair(b, at=AT), 22),
    "bookshelf": (lambda b: furniture.bookshelf(b, books=(3, 0, 2, 1), seed=1, at=AT), 24 + 5 * 6),
    "computer": (lambda b: furniture.computer(b, at=AT), 19),
    "vase": (lambda b: furniture.vase(b, size=0.3, material=CLAY, at=AT), 64),
    "plant": (lambda b: furniture.plant(b, leaves=9, size=1.2, seed=2, at=AT), 24 + 3 + 9),
    "floor lamp": (lambda b: furniture.floor_lamp(b, at=AT), 21 + 8 + 6),
    "sheets": (lambda b: furniture.sheets(b, count=4, seed=3, at=AT), 4),
}


@pytest.mark.parametrize("name", PIECES)
def test_piece_has_its_count_and_stands_where_it_was_put(name):
    make, count = PIECES[name]
    builder = SceneBuilder(name)
    make(builder)
    scene = builder.build()
    assert len(scene) == count
    assert 0 <= scene.bounds[0, 2] - AT[2] < 0.01
    assert (np.abs(scene.bounds[:, :2] - AT[:2]) < 1.2).all()


def test_books_fit_between_the_boards():
    builder = SceneBuilder("bookshelf")
    furniture.bookshelf(builder, books=(8, 8, 8, 8), seed=4)
    scene = builder.build()
    books = scene.vertices[24:].reshape(32, 5, 4, 3)
    assert books[..., 0].max() < 0.62
    for first, second in pairwise(books):
        same_board = first[..., 2].min() == second[..., 2].min()
        assert not same_board or first[..., 0].max() < second[..., 0].min()
