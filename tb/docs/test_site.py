import re
import subprocess
import sys
from pathlib import Path

import pytest

from tb.docs.contents import UNIT_PAGES
from tb.docs.hooks import OUTSIDE
from tb.docs.links import broken_links
from tb.docs.reference import markdown
from tb.docs.structure import component_classes
from tb.docs.waveforms import WAVEFORMS

ROOT = Path(__file__).parents[2]


def test_pages_of_the_navigation_exist():
    navigation = (ROOT / "mkdocs.yml").read_text().partition("\nnav:\n")[2]
    made = {*OUTSIDE, "verification-report.md", "parameters.md", "payloads.md", "units.md"}
    named = set(re.findall(r"[\w/-]+\.md", navigation)) - made
    assert "formats/registers.md" in named
    assert named <= {str(page.relative_to(ROOT / "docs")) for page in (ROOT / "docs").rglob("*.md")}


def test_units_of_the_pages_exist():
    names = [cls.__name__ for cls in component_classes().values()]
    assert all((ROOT / "docs" / page).exists() for page in UNIT_PAGES)
    assert set(UNIT_PAGES) <= set(WAVEFORMS)
    assert {name for units in UNIT_PAGES.values() for name in units} <= {
        name for name in names if names.count(name) == 1}


@pytest.mark.parametrize(("target", "is_broken"), [
    ("other.html", False), ("other.html#there", False), ("#here", False), ("https://example.org/x", False),
    ("folder/", False), ("other.html#here", True), ("#there", True), ("gone.html", True), ("folder/gone.png", True)])
def test_broken_links_are_found(tmp_path, target, is_broken):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "index.html").write_text("")
    (tmp_path / "page.html").write_text(f'<h1 id="here">x</h1><a href="{target}">y</a>')
    (tmp_path / "other.html").write_text('<h1 id="there">x</h1>')
    assert broken_links(tmp_path) == ([f"page.html: {target}"] if is_broken else [])


def test_docstrings_become_markdown():
    text = markdown("""``a < b`` and `Queue`, x < y::

    i - o

Members
-------
i, o
    What goes in,
    and out.
p
    More.

Timing
------
Latency: ``3``.""", lambda name: f"[{name}]")
    assert text == """`a < b` and [Queue], x &lt; y:

    i - o

## Members

`i`, `o`
:   What goes in,
    and out.

`p`
:   More.

## Timing

Latency: `3`."""


@pytest.mark.nightly
def test_the_site_is_built_and_all_its_links_lead_somewhere(tmp_path):
    """By the command that `make docs` runs: inside pytest it would find other modules imported than a user's does."""
    done = subprocess.run([sys.executable, "-m", "tb.docs", tmp_path / "site"], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr
    for page in UNIT_PAGES:
        text = (tmp_path / "site" / page.replace(".md", ".html")).read_text()
        assert {part for part in ("<svg", "<th>port</th>", "<strong>Timing.</strong>", "waveforms/")
                if part not in text} == set(), page
