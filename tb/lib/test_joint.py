"""A testbench of each block in Verilator, in every commit."""

from pathlib import Path

from tb.lib.joint import simulate_together

BENCHES = ["tb.control.test_section_results.TestSectionResults", "tb.ctu.test_cell_number.TestCellNumber",
           "tb.icu.test_patch_queue.TestPatchQueue", "tb.memsys.patches.test_filter.TestFilter",
           "tb.noc.test_link_sender.TestLinkSender"]


def test_every_block_has_one():
    blocks = {path.parent.name for path in (Path(__file__).parents[2] / "hw").glob("*/__init__.py")}
    assert {path.split(".")[1] for path in BENCHES} == blocks - {"lib", "board", "registers"}


def test_all_of_them_in_verilator():
    simulate_together(BENCHES)
