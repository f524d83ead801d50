"""Which of the five parts a configuration has: all of them, unless an option leaves one out."""

import pytest

from golden.engine.config import PRESETS, Config
from golden.engine.config.parts import parts

ALONE, NO_STORE = {"noc.columns": 1, "noc.rows": 1}, {"memsys.store_patches": 0}


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


def test_a_store_is_left_out_by_its_option_alone():
    assert missing(Config()) == {}
