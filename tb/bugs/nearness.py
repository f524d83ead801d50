"""Which tests are near a file, and which only notice that something has changed."""

import re
from functools import cache
from pathlib import Path

__all__ = ["change_detectors", "commit_marks", "folder_tests", "near_tests", "simulated",
           "simulator_marks"]

# More would be a folder's.
_MOST = 6
# Folders of tests that compare pages, or the wording of the sources.
_WORDING = ("tb/docs/", "tb/sources/")
# What reads sources, and a digest that somebody has recorded.
_READS = re.compile(r"\b(source_texts\(|getsource|ast\.parse)|['\"][0-9a-f]{32,}['\"]")
_TEST = re.compile(r"^def (test_\w+)\(.*?(?=^\S(?!\s*$)|\Z)", re.MULTILINE | re.DOTALL)
# Of a target of the Makefile.
_MARKS = r'^{}:.*\n(?:\t.*\n)*?\t.*(?:pytest|PYTEST).* -m "([^"]*)"'


@cache
def _tests(root: Path) -> dict[str, str]:
    """Texts of all tests by path."""
    return {path.relative_to(root).as_posix(): path.read_text() for path in sorted((root / "tb").rglob("test_*.py"))}


@cache
def change_detectors(root: Path) -> frozenset[str]:
    """Tests that fail on any change: of pages, of sources, and of what a command of the project has recorded.

    A record is a JSON file in ``tb/``; a test reads it if it names it, or imports a module of ``tb/`` that does. Of
    other files single tests count that read sources or have a digest.
    """
    records = [path.name for path in (root / "tb").rglob("*.json")]
    readers = {path.relative_to(root).as_posix()[:-3].replace("/", ".") for path in (root / "tb").rglob("*.py")
               if any(f'"{name}"' in path.read_text() for name in records)}
    found = set()
    for path, text in _tests(root).items():
        if path.startswith(_WORDING) or path[:-3].replace("/", ".") in readers or any(
                re.search(rf"(from|import) {re.escape(module)}\b", text) for module in readers):
            found.add(path)
        else:
            found |= {f"{path}::{test[1]}" for test in _TEST.finditer(text) if _READS.search(test[0])}
    return frozenset(found)


def near_tests(path: str, root: Path) -> list[str]:
    """Tests of a file's name, then those that import it, its own folder's first; no change detectors."""
    module, stem = path[:-3].replace("/", "."), Path(path).stem
    package, _, name = module.rpartition(".")
    imports = re.compile(rf"\b{re.escape(module)}\b|from {re.escape(package)} import [^\n]*\b{name}\b")
    own = [test for test in _tests(root) if Path(test).stem == f"test_{stem}"]
    users = [test for test, text in _tests(root).items() if imports.search(text)]
    mirror = f"tb/{path.removeprefix('hw/')}".rpartition("/")[0]
    found = sorted({*own, *users} - change_detectors(root),
                   key=lambda test: (test not in own, not test.startswith(mirror), test))
    return found[:_MOST]


def folder_tests(path: str, root: Path) -> list[str]:
    """The folder of a file's tests; of a folder that has folders of tests below it, those in itself.

    What lies in `hw` itself is tested with whole machines.
    """
    folder = Path("tb", *Path(path).parent.parts[path.startswith("hw/"):])
    if folder == Path("tb"):
        return ["tb/system"]
    while folder != Path("tb") and not list((root / folder).glob("test_*.py")):
        folder = folder.parent
    if folder == Path("tb"):
        return ["tb/system"]
    if any((root / folder).glob("*/test_*.py")):
        return sorted(one.relative_to(root).as_posix() for one in (root / folder).glob("test_*.py"))
    return [folder.as_posix()]


def _found(root, pattern):
    """What the Makefile says."""
    return re.search(pattern, (root / "Makefile").read_text(), re.MULTILINE)[1]


def commit_marks(root: Path) -> str:
    """By which ``make test`` selects."""
    return _found(root, _MARKS.format("test"))


def simulator_marks(root: Path) -> str:
    """By which ``make sim`` selects what ``make test`` does not."""
    return f"({_found(root, _MARKS.format('sim'))}) and not ({commit_marks(root)})"


def simulated(root: Path) -> list[str]:
    """Folders that ``make sim`` runs."""
    return [f"tb/{name}" for name in _found(root, r"^BLOCKS *:?= *(.*)$").split()]
