"""The README's cycles are those of its command."""

from tb.docs.language import ROOT
from tb.system.cycles import cycles_of
from tb.system.job_machine import TWO_CLUSTERS


@TWO_CLUSTERS
def test_cycles_are_those_of_the_page():
    cycles, = cycles_of("many rays", 2)["casts"]
    assert f"| **{cycles:,}** | cycles" in (ROOT / "README.md").read_text()
