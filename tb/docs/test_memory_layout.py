"""The page on the memory map."""

from pathlib import Path

from golden.engine.memory_map.layout_tables import layout_tables

PAGE = Path(__file__).parents[2] / "docs" / "memory-map.md"


def test_the_page_shows_the_layout():
    assert layout_tables() in PAGE.read_text()
