"""All tables of the memory system are block RAMs: as many as they need at the preset ``small``."""

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.synthesis.report import measure

# By unit; the patch cache without the fully associative placement, whose keys are all compared at once.
BLOCK_RAMS = {"CellFilter": 2, "PatchFilter": 1, "CellTable": 8, "PatchTable": 14, "PatchTypeMemory": 7,
              "LocalPatchGeometry": 11, "PatchCache-sets": 13}


@pytest.mark.nightly
@pytest.mark.parametrize("unit", BLOCK_RAMS)
def test_tables_are_block_rams(unit, tmp_path):
    assert measure("memsys", unit, PRESETS["small"], tmp_path).area.bram == BLOCK_RAMS[unit]
