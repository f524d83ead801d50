"""The verification report: tests, proofs with negative controls, and functional coverage, collected from the code.

``python -m tb.docs.verification`` prints it, of the tests of some files if they are named.
"""

import ast
import contextlib
import inspect
import io
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import click
import pytest

from tb.docs.reference import markdown
from tb.formal import declare

__all__ = ["collected", "main", "proofs", "report", "report_of"]

ROOT = Path(__file__).parents[2]
KINDS = ("commit", "sim", "nightly")
FORMAL = "tb/formal"
# By the first word of a declared test: the report's title.
PROOFS = {"holds": "holds", "reaches": "can be reached", "fails": "must fail"}


class _Collector:
    """Takes note of what pytest would run."""

    def __init__(self):
        self.items = []

    def pytest_collection_finish(self, session):
        self.items = list(session.items)


def collected(*paths: str) -> list[pytest.Function]:
    """The tests of files or folders, of all if there are none.

    Raises
    ------
    RuntimeError
        One of them cannot be read.
    """
    collector, said = _Collector(), io.StringIO()
    with contextlib.redirect_stdout(said):
        code = pytest.main(["--collect-only", "-q", "--assert=plain", "-p", "no:cacheprovider", f"--rootdir={ROOT}",
                            *(str(ROOT / path) for path in paths or ("tb",))], plugins=[collector])
    if code != pytest.ExitCode.OK:
        raise RuntimeError(said.getvalue())
    return collector.items


def report(*paths: str) -> str:
    """The page, of the tests of files or folders, of all if there are none.

    From a process of its own: pytest refuses to collect where what it rewrites has been imported already.

    Raises
    ------
    RuntimeError
        One of them cannot be read.
    """
    done = subprocess.run([sys.executable, "-m", "tb.docs.verification", *paths], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"verification report: {done.stderr}")
    return done.stdout


def report_of(items: list[pytest.Function]) -> str:
    """The page, of some tests."""
    return "\n".join([
        "# Verification report", "",
        "What there is to run, collected from the code as this page was made. How benches and proofs work: "
        "[how the hardware is proved](verification.md).", "",
        "## Tests", "",
        "Each with all the values that it is run for. *Commit*: `make test`; *simulators*: blocks in Verilator, "
        "`make sim`; *nightly*: `make nightly`, which runs those of the simulators too.", "",
        *_tests(items), "", "## Proofs", "",
        "What holds for all inputs; what must be reachable, so that no claim is vacuous; and the faults for "
        "each of which a proof must fail.", "",
        *proofs([item for item in items if _path(item).startswith(FORMAL)]), "## Functional coverage", "",
        "A testbench fails if one of its cases never occurs.", "", *_cases(), ""])


def _tests(items) -> list[str]:
    counts: dict[str, dict[str, Counter]] = {}
    for item in items:
        path = Path(_path(item))
        kinds = {mark.name for mark in item.iter_markers()} & {"nightly", "sim"}
        kind = "nightly" if "nightly" in kinds else "sim" if "sim" in kinds else "commit"
        counts.setdefault(str(path.parent), {}).setdefault(path.name, Counter())[kind] += 1
    lines = ["| folder | files | commit | simulators | nightly |", "|---|---|---|---|---|"]
    total = Counter()
    for folder, files in sorted(counts.items()):
        inside = sum(files.values(), Counter())
        total += inside
        lines.append(f"| `{folder}` | {len(files)} | " + " | ".join(str(inside[kind]) for kind in KINDS) + " |")
    lines.append(f"| all | {sum(map(len, counts.values()))} | " + " | ".join(str(total[kind]) for kind in KINDS) + " |")
    for folder, files in sorted(counts.items()):
        lines += ["", f"### {folder}", "", "| bench | commit | simulators | nightly |", "|---|---|---|---|", *(
            f"| `{name}` | " + " | ".join(str(count[kind] or "") for kind in KINDS) + " |"
            for name, count in sorted(files.items()))]
    return lines


def proofs(items: Iterable[pytest.Function]) -> list[str]:
    """Lines on each file of proofs: what is asserted, proved and reached, and which faults must be noticed."""
    modules: dict[str, list] = {}
    for item in items:
        modules.setdefault(item.module.__name__, []).append(item)
    lines = []
    for name, tests in sorted(modules.items()):
        declared = [test for test in tests if test.function.__module__ == declare.__name__]
        if not declared:
            continue
        lines += [f"### {_words(name.rpartition('.')[2])}", ""]
        for rules in vars(tests[0].module).values():
            if inspect.isfunction(rules) and rules.__module__ == name and rules.__doc__ and (
                    "Assert(" in inspect.getsource(rules)):
                lines += [markdown(inspect.getdoc(rules).split("\n\n")[0]).replace("\n", " "), ""]
        lines += ["| | |", "|---|---|"]
        for kind, title in PROOFS.items():
            cases = [_case_words(test) for test in declared if test.callspec.id.partition(" ")[0] == kind]
            lines += [f"| {title} | {'; '.join(cases)} |"]
        lines += [""]
    return lines


def _case_words(test):
    words = " ".join([_words(test.originalname) + ":", *test.callspec.id.split(" ")[1:]]).removesuffix(":")
    return words + (" (nightly)" if test.get_closest_marker("nightly") else "")


def _cases() -> list[str]:
    """Of all files with cases, which they are: strings given to `Coverage` or `assert_all_occur`."""
    lines = ["| in | cases |", "|---|---|"]
    for path in sorted((ROOT / "tb").rglob("*.py")):
        text, names = path.read_text(), {}
        if not re.search(r"\b(Coverage|assert_all_occur)\(", text):
            continue
        tree = ast.parse(text)
        constants = {target.id: node.value for node in tree.body if isinstance(node, ast.Assign)
                     for target in node.targets if isinstance(target, ast.Name)}
        for node in ast.walk(tree):
            called = getattr(node.func, "id", getattr(node.func, "attr", "")) if isinstance(node, ast.Call) else ""
            if called in ("Coverage", "assert_all_occur") and node.args:
                names |= dict.fromkeys(_strings(node.args[0], constants))
        if names and path.name != "test_coverage.py":
            lines.append(f"| `{path.relative_to(ROOT)}` | {', '.join(names)} |")
    return lines


def _strings(node, constants) -> list[str]:
    """Names of cases in an expression: strings of a tuple, or keys of a dictionary."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else []
    if isinstance(node, ast.Name):
        return _strings(constants[node.id], constants) if node.id in constants else []
    if isinstance(node, ast.Starred):
        return _strings(node.value, constants)
    parts = node.keys if isinstance(node, ast.Dict) else getattr(node, "elts", [])
    return [name for part in parts if part is not None for name in _strings(part, constants)]


def _path(item):
    return str(item.path.relative_to(ROOT))


def _words(name):
    return name.removeprefix("test_").replace("_", " ")


@click.command()
@click.argument("paths", nargs=-1)
def main(paths):
    """Print the report of the tests of PATHS, of all if there are none."""
    click.echo(report_of(collected(*paths)), nl=False)


if __name__ == "__main__":
    main()
