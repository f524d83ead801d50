"""Figures and lists of pages that no command prints."""

import re

from hw.board.frame import CHECK_BYTES, HEADER_BYTES
from hw.board.program import Operation
from hw.board.record import record
from hw.board.view import BOARD, board_view
from tb.docs.language import ROOT


def test_bytes_of_a_view():
    program = record(board_view(BOARD, scene="cornell", pixels=(64, 64), cell=0.25).image, BOARD)
    # The frames of a cast; an error's frame replaces those that remain.
    steps = program.steps[:program.error]
    frames = sum(step.operation == Operation.FRAME for step in steps)
    size = (frames * (HEADER_BYTES + CHECK_BYTES) + 4 * sum(step.operation == Operation.WORD for step in steps)
            + sum(step.value for step in steps if step.operation == Operation.BYTES))
    quoted, = re.findall(r"A view of 64 x 64 rays is ([\d,]+) bytes", (ROOT / "docs" / "board.md").read_text())
    assert quoted.replace(",", "") == str(size)


def test_every_module_of_the_memory_system_is_on_a_page():
    text = "\n".join((ROOT / "docs" / name).read_text() for name in (
        "main-memory.md", "memory-path.md", "caches.md", "traversal-unit.md"))
    modules = {path.stem for path in (ROOT / "hw" / "memsys").glob("*.py")} - {"__init__"}
    named = set(re.findall(r"`(?:hw/memsys/)?(\w+?)(?:\.py)?`", text))
    assert {module for module in modules if not {module, module.title().replace("_", "")} & named} == set()
