from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest

import golden
from golden.base import source_digest as module
from golden.base.source_digest import PACKAGES, source_digest

ROOT = Path(__file__).parents[3]


@pytest.fixture
def digest_of(tmp_path, monkeypatch):
    """The digest of one package whose files are the given ones."""
    def digest(files):
        for number in range(99):
            folder = tmp_path / str(number)
            if not folder.exists():
                break
        for name, text in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        spec = ModuleSpec("golden", None, is_package=True)
        spec.submodule_search_locations = [str(folder)]
        monkeypatch.setattr(module, "find_spec", lambda name: spec if name == "golden" else None)
        return source_digest.__wrapped__()
    return digest


FILES = {"a.py": "x = 1", "b/c.py": "y = 2"}


@pytest.mark.parametrize("other", [
    {"a.py": "x = 2"}, {"b/c.py": "y = 2 "}, {"d.py": ""}, {"b/table.in": "1"}],
    ids=["content", "blank", "new", "table"])
def test_any_change_of_a_file_changes_the_digest(digest_of, other):
    assert digest_of(FILES) != digest_of(FILES | other)


def test_names_and_borders_of_files_count(digest_of):
    texts = [{"a.py": "xy"}, {"b.py": "xy"}, {"a.py": "x", "b.py": "y"}, {"a.py": "", "b.py": "xy"}]
    assert len({digest_of(files) for files in texts}) == len(texts)


def test_what_the_interpreter_and_editors_write_does_not_count(digest_of):
    others = {"__pycache__/a.cpython-311.pyc": "1", "b/__pycache__/c.pyc": "2", ".a.py.swp": "3", ".git/HEAD": "4"}
    assert digest_of(FILES) == digest_of(FILES | others)


def test_the_packages_are_those_that_are_installed():
    found = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"benchmarks", "tb"}
    assert set(PACKAGES) == found
    assert golden.__name__ in PACKAGES
    assert source_digest() == source_digest.__wrapped__()
