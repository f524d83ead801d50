"""The tables of docs/architecture.md name the blocks that the hardware has."""

import re
from pathlib import Path

import pytest

from tb.docs.tiny_structures import tiny_structures

# Looks at what tb/docs/test_structure.py looks at.
pytestmark = pytest.mark.xdist_group("structures")

PAGE = Path(__file__).parents[2] / "docs" / "architecture.md"


def tables(text):
    """Of each component whose diagram the page shows: the blocks of the table below it, by name and class."""
    found = {}
    for name, below in re.findall(r"<!-- diagram (\w+) -->\n(.*?)(?=\n<!-- diagram|\n## |\Z)", text, re.DOTALL):
        found[name] = set(re.findall(r"^\| `(\w+)` \| `(\w+)` \|", below, re.MULTILINE))
    return found


@pytest.fixture
def blocks():
    """Of each component its submodules that are not of the library, those of several of a kind by the first one."""
    return {cls.__name__: {(block.name, block.cls.__name__) for block in structure.blocks
                           if not block.cls.__module__.startswith("hw.lib")}
            for cls, structure in tiny_structures().items()}


def test_blocks_of_the_page_are_in_the_code(blocks):
    shown = tables(PAGE.read_text())
    assert {"Engine", "Cluster", "TraversalUnit", "MemorySystem", "IntersectionUnit", "PatchNetwork"} <= set(shown)
    for name, named in shown.items():
        assert named <= blocks[name], f"docs/architecture.md: {name}"


def test_the_page_leaves_no_main_block_out(blocks):
    shown = tables(PAGE.read_text())
    small = {"WorkCount", "Timeout", "FirstFault", "VoidCheck"}
    for name in ("Engine", "Cluster", "TraversalUnit", "RayTraversal", "MemorySystem", "IntersectionUnit",
                 "SystemBusInterface", "PatchNetwork"):
        missing = {cls for _, cls in blocks[name]} - {cls for _, cls in shown[name]} - small
        assert not missing, f"docs/architecture.md: {name}"


@pytest.mark.parametrize(("text", "expected"), [
    ("<!-- diagram A -->\n\n| `x` | `Y` | z |\n\n<!-- diagram B -->\n\n## C\n\n| `u` | `V` | z |\n",
     {"A": {("x", "Y")}, "B": set()})])
def test_tables_belong_to_the_diagram_above_them(text, expected):
    assert tables(text) == expected
