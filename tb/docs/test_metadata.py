"""What other programs read of the project: citation, development container, and the marks of its pages."""

import json
import re
import tomllib

import pytest

from tb.docs.language import ROOT
from tb.docs.page_commands import pages

NEEDED = ("gcc", "g++", "make", "perl")


def test_the_citation_has_the_package_s_version_and_licence():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = dict(re.findall(r"^([\w-]+): (\S.*)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE))
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
    assert citation["cff-version"] == "1.2.0"


def test_the_container_has_what_the_readme_requires():
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text())
    readme = (ROOT / "README.md").read_text()
    assert container["postCreateCommand"] == "make setup"
    for tool in NEEDED:
        assert tool in container["onCreateCommand"].split()
        assert re.search(rf"(?<!\w){re.escape(tool)}(?!\w)", readme)


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 90


def test_the_pages_have_at_most_40000_words():
    """A fact that is added replaces another one, or a sentence that says it twice."""
    assert sum(len(page.read_text().split()) for page in pages()) <= 40_000


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_tables_and_blocks_are_whole(page):
    assert torn(page.read_text()) == []


@pytest.mark.parametrize(("text", "expected"), [
    ("| a |\n|---|\n| b |\n\n| c |\n|---|\n", []), ("| a |\n|---|\n\n| b |\n| c |\n", ["| b |"]),
    ("```sh\nx\n```\n", []), ("sh\nx\n```\n", ["```"])])
def test_torn_tables_and_blocks_are_found(text, expected):
    assert torn(text) == expected


def torn(text):
    """First rows of tables without a header, and the last mark of a block of code that has no other end."""
    rows = [table.split("\n") for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)]
    marks = re.findall(r"^ *(```)", text, re.MULTILINE)
    return [first for first, *more in rows if not more[0].startswith("|---")] + marks[:len(marks) % 2]
