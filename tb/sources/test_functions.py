"""Functions stay short: one that is longer than a hundred lines has a reason here."""

import pytest

from tb.sources.source_trees import functions, source_trees

# All sources are parsed in one of pytest-xdist's processes.
pytestmark = pytest.mark.xdist_group("sources")

MOST = 100
ONE_LIST = "one pipeline, stage by stage; cut into methods it would pass its signals through attributes"
REASONS = {
    "hw/ctu/row_pieces.py: RowPieces.elaborate": ONE_LIST,
    "hw/icu/intersection_unit.py: IntersectionUnit.elaborate": "one netlist: submodules, then the streams between them",
    "hw/memsys/istructure.py: IStructure.elaborate": ONE_LIST,
    "hw/memsys/preload_dma.py: PreloadDma.elaborate": ONE_LIST,
}


def test_long_functions_have_a_reason():
    found = {f"{path}: {name}": lines for folder in ("golden", "hw", "radiosity", "tb")
             for path, tree in source_trees(folder).items() for name, lines in functions(tree) if lines > MOST}
    assert found.keys() == REASONS.keys(), {name: found.get(name) for name in found.keys() ^ REASONS.keys()}
