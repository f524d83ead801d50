"""Pages beside an exported engine: complete, and without links that lead nowhere."""

import re

from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.memory_map import REGIONS
from hw.cluster import COUNTERS
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from radiosity.flow.package.pages import core_pages

PAGES = core_pages()


def test_links_lead_to_these_pages_or_out():
    targets = {target for text in PAGES.values() for target in re.findall(r"\]\(([^)]*)\)", text)}
    assert "formats.md" in targets
    assert all(target in PAGES or target.startswith("https://") for target in targets)


def test_every_register_error_and_counter_is_explained():
    for name in (*(one.name for one in ENGINE_REGISTERS), *(one.name for one in ErrorCode), *COUNTERS):
        assert f"`{name}`" in PAGES["registers.md"]


def test_every_field_in_memory_is_explained():
    for region in (DESCRIPTOR, COMPLETION, *REGIONS):
        part = PAGES["formats.md"].partition(f"### {region.name}\n")[2].partition("\n### ")[0]
        assert all(f"| `{field.name}` |" in part for field in region.fields), region.name
        assert f"{region.dtype.itemsize} bytes" in part
