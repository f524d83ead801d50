"""The licence in every file of an exported core, and no reference to what the core has not."""

import json
import re
from pathlib import Path

import pytest

from radiosity.flow.package.notice import COPYRIGHT, LICENCE, with_notice

ROOT = Path(__file__).parents[4]


def test_the_licence_is_that_of_the_project(exported):
    text = (ROOT / "LICENSE").read_text()
    assert (exported / "LICENSE").read_text() == text
    assert COPYRIGHT in text
    facts = json.loads((exported / "radiosity_engine.json").read_text())
    assert (facts["licence"], facts["copyright"]) == (LICENCE, COPYRIGHT)


def test_every_file_retains_the_notice(exported):
    """Once, near its beginning or at the end of a page; a job is data of its user."""
    files = [path for path in exported.rglob("*") if path.is_file() and path.parent.name != "job"]
    assert {path.suffix for path in files} >= {".sv", ".v", ".vhd", ".c", ".cpp", ".h", ".py", ".md", ".core", ".rdl"}
    for path in files:
        text = path.read_text()
        assert text.count(COPYRIGHT) == 1, path
        assert LICENCE in text or path.name == "LICENSE", path


def test_a_file_of_an_unknown_kind_is_an_error():
    with pytest.raises(KeyError, match="bin"):
        with_notice("a/b.bin", "text")


def test_pages_name_no_page_that_is_not_here(exported):
    for page in exported.glob("*.md"):
        text = page.read_text()
        assert all((exported / name).exists() for name in re.findall(r"\b[\w-]+\.md\b", text)), page
        assert not re.search(r"\b(?:docs|hw|golden|tb)/", text), page
