"""Checks of the tables of a memory image."""

from collections.abc import Mapping

import numpy as np

from golden.errors import InputError
from golden.memory_map.layout import EVERY_CLUSTER, GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, WEIGHT_BITS

__all__ = ["check_image"]


def check_image(image: Mapping[str, np.ndarray]):
    """Every pointer lies within its table, and every number fits the bits that the machine has for it.

    Parameters
    ----------
    image
        An array of records per region of `golden.memory_map.layout.REGIONS`.

    Raises
    ------
    InputError
        A table breaks a rule; the message names both.
    """
    _check_tables(image)
    patches = image["patches"]
    _require((patches["kind"] == 0).all(), "patches.kind must be 0")
    # Four vertices of 0 are the machine's answer for a patch that a cluster does not hold.
    _require((patches["vertex"].any(axis=1) | patches["top"].any(axis=1)).all(),
             "patches.vertex must not be 0 of all vertices")
    residence, held = image["residence"], image["residents"]["patch"][:int(image["clusters"]["residents"][0])]
    _require(((residence["cluster"] >= EVERY_CLUSTER) & (residence["cluster"] < len(image["clusters"]))).all(),
             f"residence.cluster must be {EVERY_CLUSTER} to {len(image['clusters']) - 1}")
    everywhere = np.flatnonzero(residence["cluster"] == EVERY_CLUSTER)
    address = residence["address"][everywhere]
    _require(((address >= 0) & (address < len(held))).all() and np.array_equal(held[address], everywhere),
             "residence.address of a copy in every cluster must be its index among the residents of cluster 0")


def _check_tables(image):
    """Pointers and numbers, without the copies that every cluster has."""
    patches, cells, clusters, shells = (len(image["patches"]), len(image["cells"]), image["clusters"], image["shells"])
    _require(len(image["cell_grid"]) == 1, "cell_grid must be one record")
    (grid,) = image["cell_grid"]
    _require(np.prod(grid["shape"].astype(np.uint64)) == cells, "cells must be as many as cell_grid.shape states")
    _require((grid["shape"] < 1 << GRID_SHAPE_BITS).all(),
             f"cell_grid.shape must be below {1 << GRID_SHAPE_BITS}, not {grid['shape'].tolist()}")
    _within(image["cells"]["pointer"], image["cells"]["count"], len(image["patch_lists"]), "cells", "patch_lists")
    _require((image["patches"]["id"] < patches).all(), f"patches.id must be below {patches}")
    for region in "patch_lists", "subshells", "residents":
        _require((image[region]["patch"] < patches).all(), f"{region}.patch must be below {patches}")
    _within(clusters["first_subshell"], clusters["subshells"], len(image["subshells"]), "clusters", "subshells")
    _within(clusters["first_resident"], clusters["residents"], len(image["residents"]), "clusters", "residents")
    _within(shells["first_row"], shells["rows"], len(image["grid_rows"]), "shells", "grid_rows")
    _within(shells["first_column"], shells["columns"], len(image["grid_columns"]), "shells", "grid_columns")
    _check_grid_rays(shells)
    _require((image["rows"]["weight"] < 1 << WEIGHT_BITS).all(), f"rows.weight must be below {1 << WEIGHT_BITS}")
    _require(len(image["residence"]) == patches,
             f"residence must be {patches} records, not {len(image['residence'])}")


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
