"""Files and tests that pages name exist."""

import ast
import re

import pytest

from tb.docs.language import ROOT
from tb.docs.page_commands import pages

# ``foo`` stands for any component.
_NAMED = re.compile(r"(?<![\w./])(?P<path>(?:benchmarks|docs|golden|hw|radiosity|tb)/(?:\w+/)*(?!\w*foo\b)[\w-]+\.\w+)"
                    r"(?:::(?P<name>\w+))?")


def missing_of(text):
    """Files that a text names and that do not exist, and names that their modules do not define."""
    named = {(match["path"], match["name"]) for match in _NAMED.finditer(text)}
    return sorted(f"{path}::{name}" if name else path for path, name in named
                  if not (ROOT / path).exists() or (name and name not in defined_in(ROOT / path)))


def defined_in(path):
    """Names that a module defines."""
    body = ast.parse(path.read_text()).body
    return {node.name for node in body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)} | {
        target.id for node in body if isinstance(node, ast.Assign) for target in node.targets
        if isinstance(target, ast.Name)}


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_files_and_tests_exist(page):
    assert missing_of(page.read_text()) == []


def test_what_does_not_exist_is_found():
    text = "`tb/docs/test_nothing.py`, `tb/docs/test_site.py::test_nothing`, `hw/icu/foo.py`, `tb/icu/test_foo.py`, " \
           "[a file](docs/nothing.csv), `tb/docs/test_paths_of_pages.py::test_files_and_tests_exist`"
    assert missing_of(text) == ["docs/nothing.csv", "tb/docs/test_nothing.py", "tb/docs/test_site.py::test_nothing"]
