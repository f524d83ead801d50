"""Checks of the tables of a memory image."""

from collections.abc import Mapping

import numpy as np

from golden.base.errors import InputError
from golden.engine.memory_map.layout import EVERY_CLUSTER, GRID_POSITION_BITS, GRID_RAY_BITS, GRID_SIDE_BITS
from golden.engine.memory_map.rules import RULES, RuleKind

__all__ = ["check_image"]


def check_image(image: Mapping[str, np.ndarray]):
    """The records have all of `golden.engine.memory_map.rules.RULES`, positions and reaches of grid rays do not wrap,
    and the tables fit each other.

    Parameters
    ----------
    image
        An array of records per region of `golden.engine.memory_map.layout.REGIONS`.

    Raises
    ------
    InputError
        A table breaks a rule; the message names both.
    """
    _require(len(image["cell_grid"]) == 1, "cell_grid must be one record")
    (grid,), patches = image["cell_grid"], image["patches"]
    _require(np.prod(grid["shape"].astype(np.uint64)) == len(image["cells"]),
             "cells must be as many as cell_grid.shape states")
    for rule in RULES:
        if rule.kind is RuleKind.GRID:
            _check_grid_rays(image["shells"])
        else:
            _require(rule.holds(image).all(), rule.requirement(image))
    for region, field in (("shells", "row_border"), ("grid_rows", "position"), ("grid_rows", "column_reach"),
                          ("grid_rows", "column_border"), ("grid_columns", "position")):
        _require((np.abs(image[region][field].astype(np.int64)) < 1 << GRID_POSITION_BITS).all(),
                 f"{region}.{field} must be below 2^{GRID_POSITION_BITS} in magnitude; use a wider view or fewer rays")
    _require(len(image["residence"]) == len(patches),
             f"residence must be {len(patches)} records, not {len(image['residence'])}")
    # Four vertices of 0 are the machine's answer for a patch that a cluster does not hold.
    _require((patches["vertex"].any(axis=1) | patches["top"].any(axis=1)).all(),
             "patches.vertex must not be 0 of all vertices")
    residence, held = image["residence"], image["residents"]["patch"][:int(image["clusters"]["residents"][0])]
    everywhere = np.flatnonzero(residence["cluster"] == EVERY_CLUSTER)
    address = residence["address"][everywhere]
    _require(((address >= 0) & (address < len(held))).all() and np.array_equal(held[address], everywhere),
             "residence.address of a copy in every cluster must be its index among the residents of cluster 0")


def _check_grid_rays(shells):
    for axis in "rows", "columns":
        _require((shells[axis] < 1 << GRID_SIDE_BITS).all(), f"shells.{axis} must be below {1 << GRID_SIDE_BITS}")
    rays = shells["rows"].astype(np.uint64) * shells["columns"]
    _require(np.array_equal(shells["first_ray"], np.cumsum(rays) - rays),
             "shells.first_ray must be the number of grid rays of the shells before")
    _require(rays.sum() <= 1 << GRID_RAY_BITS, f"grid rays must be at most {1 << GRID_RAY_BITS}, not {rays.sum()}")


def _require(condition, requirement):
    if not condition:
        raise InputError(f"memory image: {requirement}")
