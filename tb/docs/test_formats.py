"""The tables of docs/formats/ are those of the code."""

import pytest

from golden.engine.jobs.job_tables import job_tables
from golden.engine.memory_map.layout_tables import layout_tables
from tb.docs.language import ROOT


@pytest.mark.parametrize(("page", "tables"), [("jobs.md", job_tables), ("images.md", layout_tables)])
def test_the_page_shows_all_fields(page, tables):
    assert (ROOT / "docs" / "formats" / page).read_text().endswith(f"\n\n{tables()}")
