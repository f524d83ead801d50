"""Which of the five parts a configuration has: all of them, unless an option leaves one out."""

import pytest

from golden.engine.config import PRESETS, Config
from golden.engine.config.parts import parts

ALONE, NO_STORE = {"noc.columns": 1, "noc.rows": 1, "noc.patch_nodes": 0}, {"memsys.store_patches": 0}


def missing(config):
    """What a configuration has not, with the options that have left it out."""
    return {part.name: {word.strip("(),") for word in part.about.split() if "=" in word} for part in parts(config)
            if not part.size}


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_has_five_parts(preset):
    assert PRESETS[preset].noc.nodes > 1
    assert (len(parts(PRESETS[preset])), missing(PRESETS[preset])) == (5, {})


@pytest.mark.parametrize("preset", PRESETS)
def test_what_is_missing_is_an_option(preset):
    """A cluster alone keeps its store; grid rays that wait are an I-structure too."""
    config, router = PRESETS[preset], {"router": {"noc.columns=1", "noc.rows=1"}}
    assert missing(config.replace(ALONE)) == router
    store = {} if config.ctu.subshells else {"I-structure": {"memsys.store_patches=0"}}
    assert missing(config.replace(NO_STORE)) == store
    assert missing(config.replace(ALONE | NO_STORE)) == router | store


def test_sizes_are_of_all_clusters():
    config = PRESETS["small"].replace({"ctu.pipelines": 3, "icu.rays": 2048, "memsys.own_patches": 64,
                                       "memsys.cell_lines": 16, "memsys.patch_lines": 32, "memsys.store_patches": 8,
                                       "memsys.store_requests": 4, "noc.columns": 3})
    assert [part.size for part in parts(config)] == [
        "6 x 3 pipelines", "6 x 2048 rays", "6 x 64 patches, caches of 16 and 32 lines",
        "6 x store of 8 patches, 4 requests", "12 in mesh 3 x 2"]
    assert parts(config.replace({"noc.networks": "virtual"}))[-1].size == "6 in mesh 3 x 2"
    assert parts(config.replace(ALONE))[0].size == "3 pipelines"


def test_patch_nodes_have_patches_and_routers_alone():
    config = PRESETS["tiny"].replace({"noc.columns": 3, "noc.patch_nodes": 1})
    assert [part.size for part in parts(config)] == [
        "2 x 2 pipelines", "2 x 4096 rays", "3 x 256 patches, caches of 256 and 256 lines",
        "2 x store of 32 patches, 4 requests", "6 in mesh 3 x 1"]
    assert "from cluster to cluster and to 1 patch node (noc.patch_nodes)" in parts(config)[-1].about
    assert "from the cluster to 2 patch nodes (" in parts(config.replace({"noc.patch_nodes": 2}))[-1].about


def test_a_store_is_left_out_by_its_option_alone():
    assert missing(Config()) == {}
