"""Checks of the tables of a memory image."""

from collections.abc import Mapping

import numpy as np

from golden.errors import InputError
from golden.memory_map.layout import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, WEIGHT_BITS

__all__ = ["check_image"]


def check_image(image: Mapping[str, np.ndarray]):
    """Every pointer lies within its table, and every number fits the bits that the machine has for it.

    Parameters
    ----------
    image
        An array of records per region, for example a `golden.memory_map.MemoryImage`.

    Raises
    ------
    InputError
        A table breaks a rule; the message names both.
    """
    patches, cells = len(image["patches"]), len(image["cells"])
    for region in "cell_grid", "frustum":
        _require(len(image[region]) == 1, f"{region} must be one record")
    (grid,), (frustum,) = image["cell_grid"], image["frustum"]
    columns, rows = int(frustum["columns"]), int(frustum["rows"])
    _require(np.prod(grid["shape"].astype(np.uint64)) == cells, "cells must be as many as cell_grid.shape states")
    _require((grid["shape"] < 1 << GRID_SHAPE_BITS).all(),
             f"cell_grid.shape must be below {1 << GRID_SHAPE_BITS}, not {grid['shape'].tolist()}")
    _within(image["cells"]["pointer"], image["cells"]["count"], len(image["patch_lists"]), "cells", "patch_lists")
    _require((image["patches"]["id"] < patches).all(), f"patches.id must be below {patches}")
    for region in "patch_lists", "subshells", "residents":
        _require((image[region]["patch"] < patches).all(), f"{region}.patch must be below {patches}")
    _require((image["near_cells"]["cell"] < cells).all(), f"near_cells.cell must be below {cells}")
    clusters = image["clusters"]
    for axis, end in ("column", columns), ("row", rows):
        first, last = clusters[f"first_{axis}"], clusters[f"end_{axis}"]
        _require(((first < last) & (last <= end)).all(), f"clusters: sections must lie within the {axis}s")
    _within(clusters["first_subshell"], clusters["subshells"], len(image["subshells"]), "clusters", "subshells")
    _within(clusters["first_resident"], clusters["residents"], len(image["residents"]), "clusters", "residents")
    shells = image["shells"]
    _within(shells["first_row"], shells["rows"], len(image["grid_rows"]), "shells", "grid_rows")
    _within(shells["first_column"], shells["columns"], len(image["grid_columns"]), "shells", "grid_columns")
    _check_grid_rays(shells)
    _require((image["rows"]["weight"] < 1 << WEIGHT_BITS).all(), f"rows.weight must be below {1 << WEIGHT_BITS}")
    for region, count in (("columns", columns), ("rows", rows), ("hits", columns * rows), ("residence", patches),
                          ("sums", patches + 1)):
        _require(len(image[region]) == count, f"{region} must be {count} records, not {len(image[region])}")


def _check_grid_rays(shells):
    for axis in "rows", "columns":
        _require((shells[axis] < 1 << GRID_SIDE_BITS).all(), f"shells.{axis} must be below {1 << GRID_SIDE_BITS}")
    rays = shells["rows"].astype(np.uint64) * shells["columns"]
    _require(np.array_equal(shells["first_ray"], np.cumsum(rays) - rays),
             "shells.first_ray must be the number of grid rays of the shells before")
    _require(rays.sum() <= 1 << GRID_RAY_BITS, f"grid rays must be at most {1 << GRID_RAY_BITS}, not {rays.sum()}")


def _within(first, count, length, region, table):
    ends = first.astype(np.uint64) + count.astype(np.uint64)
    _require((ends <= length).all(), f"{region} must point into the {length} records of {table}")


def _require(condition, requirement):
    if not condition:
        raise InputError(f"memory image: {requirement}")
