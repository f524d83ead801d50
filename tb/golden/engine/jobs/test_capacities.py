"""Tables that a machine has no room for are refused before anything is loaded."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.jobs.capacities import check_capacities
from golden.engine.memory_map import MemoryImage
from tb.golden.engine.jobs.jobs import CONFIG, job

LISTS = CONFIG.replace({"ctu.subshell_bits": 6})


@pytest.fixture(scope="module")
def image():
    return job().phases[0].image


def test_an_image_for_other_nodes_is_refused(image):
    check_capacities(image, CONFIG)
    with pytest.raises(InputError, match="It must be for 4 nodes, not 2"):
        check_capacities(image, CONFIG.replace({"noc.columns": 4}))


# By region: its capacity, and the records that it can hold besides.
CAPACITIES = {
    "columns": ("Columns", 1 << CONFIG.icu.side_bits, 0), "rows": ("Rows", 1 << CONFIG.icu.side_bits, 0),
    "patches": ("Patches", 1 << CONFIG.icu.patch_bits, 0), "cells": ("Cells", CONFIG.memsys.scene_cells, 0),
    "shells": ("Shells", 1 << CONFIG.ctu.shell_bits, 2),
    "grid_rows": ("Rows of grid rays", 1 << CONFIG.ctu.grid_row_bits, 0),
    "grid_columns": ("Columns of grid rays", 1 << CONFIG.ctu.grid_column_bits, 0)}


@pytest.mark.parametrize("region", CAPACITIES)
def test_capacities(image, region):
    what, most, besides = CAPACITIES[region]
    for count in most - 1, most, most + 1:
        records = np.zeros(count - besides, dtype=image[region].dtype)
        changed = MemoryImage({**image.regions, region: records})
        if count <= most:
            check_capacities(changed, CONFIG)
        else:
            with pytest.raises(InputError, match=rf"{what} must be at most {most} \(.*\), not {count}"):
                check_capacities(changed, CONFIG)


@pytest.mark.parametrize(("config", "field", "most", "message"), [
    (CONFIG, "residents", CONFIG.memsys.own_patches, "Patches of a resident set"),
    (CONFIG.replace({"noc.patch_nodes": 1}), "residents", CONFIG.memsys.own_patches, "Patches of a resident set"),
    (CONFIG, "subshells", 0, "Subshells of a cluster"), (LISTS, "subshells", 64, "Subshells of a cluster")])
def test_capacities_of_a_node(image, config, field, most, message):
    clusters = image["clusters"].copy()
    changed = MemoryImage({**image.regions, "clusters": clusters})
    for value in range(max(0, most - 1), most + 2):
        clusters[field][1] = value
        if value <= most:
            check_capacities(changed, config)
        else:
            with pytest.raises(InputError, match=f"{message} must be at most"):
                check_capacities(changed, config)


def test_clusters_are_their_nodes(image):
    clusters = image["clusters"].copy()
    clusters["processor"] = np.array([1, 0])
    with pytest.raises(InputError, match="Cluster k must be processor k"):
        check_capacities(MemoryImage({**image.regions, "clusters": clusters}), CONFIG)
