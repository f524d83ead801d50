"""Pieces of furniture fit together."""

from itertools import pairwise

from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture


def test_books_fit_between_the_boards():
    builder = SceneBuilder("bookshelf")
    furniture.bookshelf(builder, books=(8, 8, 8, 8), seed=4)
    scene = builder.build()
    books = scene.vertices[24:].reshape(32, 5, 4, 3)
    assert books[..., 0].max() < 0.62
    for first, second in pairwise(books):
        same_board = first[..., 2].min() == second[..., 2].min()
        assert not same_board or first[..., 0].max() < second[..., 0].min()
