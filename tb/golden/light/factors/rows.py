"""Rows of form factors, for tests of them."""

from golden.cast.grid import Grid
from golden.light.factors.rows import FactorRows

__all__ = ["rows_of"]


def rows_of(scene, **settings):
    """Rows of a scene, cast by `grid`."""
    return FactorRows(scene, Grid(scene), **settings)
