"""A run and a worker compare the versions of all libraries that the golden model's casts and light import."""

import ast
import sys
from importlib.metadata import version
from pathlib import Path

from golden.base.library_versions import library_versions

GOLDEN = Path(__file__).parents[3] / "golden"
# They read and write files, and measure.
OTHERS = {"OpenEXR", "PIL", "pandas", "tqdm", "trimesh", "xarray"}


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


def test_what_computes_is_named():
    libraries = {name.partition(".")[0] for folder in ("base", "cast", "engine", "light")
                 for path in (GOLDEN / folder).rglob("*.py") for name in imported(path)}
    assert libraries - {"golden"} - sys.stdlib_module_names - OTHERS == library_versions().keys()


def test_each_has_its_version():
    assert library_versions("embree") == {name: version(name) for name in library_versions("embree")}
    assert "embreex" not in library_versions("grid")


def test_a_compiler_that_is_not_active_has_no_version(monkeypatch):
    monkeypatch.setattr("golden.base.library_versions.is_compiler_active", lambda: False)
    found = library_versions.__wrapped__()
    assert {name for name, value in found.items() if value == "none"} == {"numba", "llvmlite"}
