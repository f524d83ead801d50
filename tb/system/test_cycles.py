"""The README's cycles are those of its command."""

from pathlib import Path

from tb.system.cycles import cycles_of
from tb.system.job_machine import TWO_CLUSTERS

README = Path(__file__).parents[2] / "README.md"


@TWO_CLUSTERS
def test_cycles_are_those_of_the_page():
    cycles, = cycles_of("many rays", 2)["casts"]
    assert f"| **{cycles:,}** | cycles" in README.read_text()
