"""Bugs of a list, one at a time in a copy of the last commit, and the tests that notice them.

A list is a TOML file of tables ``[[bug]]`` with the texts ``id``, ``class`` (which part of the machine it is in),
``file``, ``old``, ``new`` and ``does`` (what is wrong then). ``old`` is in the file exactly once.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import click

__all__ = ["apply", "main", "near_tests", "read_list"]

BUILD = Path("build") / "bugs"
# What runs after the tests near a bug, so that most bugs meet the tests of whole machines before all others.
WHOLE = ["tb/system", "tb"]
KEYS = {"id", "class", "file", "old", "new", "does"}
# Exit codes of pytest with which tests notice a bug: a failure, or an error while the tests are collected.
NOTICED = (1, 2, 3)
# The exit code of pytest when the options leave none of the tests.
NONE_SELECTED = 5
NO_END, UNNAMED = "no end within", "pytest"


def read_list(path: Path) -> dict[str, dict[str, str]]:
    """The bugs of a list by id.

    Raises
    ------
    ValueError
        A bug lacks a field, or two share an id.
    """
    bugs = tomllib.loads(path.read_text())["bug"]
    for bug in bugs:
        if set(bug) != KEYS or not all(isinstance(value, str) for value in bug.values()):
            raise ValueError(f"Fields of a bug must be the texts {sorted(KEYS)}, not {bug!r}")
    ids = [bug["id"] for bug in bugs]
    if twice := [bug_id for bug_id in ids if ids.count(bug_id) > 1]:
        raise ValueError(f"Ids of bugs must differ, not be {twice[0]} twice")
    return {bug["id"]: bug for bug in bugs}


def apply(bug: dict[str, str], root: Path, *, write: bool = True) -> None:
    """Replace a bug's text below ``root``; without ``write`` only check that this is possible.

    Raises
    ------
    ValueError
        The text is not there exactly once, or the new text is the same.
    """
    text = (root / bug["file"]).read_text()
    if text.count(bug["old"]) != 1 or bug["old"] == bug["new"]:
        raise ValueError(f"Text of bug {bug['id']} must be in {bug['file']} once and differ from the new text; "
                         f"it is there {text.count(bug['old'])} times")
    if write:
        (root / bug["file"]).write_text(text.replace(bug["old"], bug["new"]))


def near_tests(file: str, root: Path) -> list[str]:
    """The tests nearest to a file, in the order in which they run: ``tb/icu/test_sbb.py`` of ``hw/icu/sbb.py`` if it
    exists, then its folder. Of a folder without tests it is the folder above it, of what only whole machines test
    ``tb/system``.
    """
    source = Path(file)
    folder = Path("tb", *source.parent.parts[source.parts[:1] == ("hw",):])
    while folder != Path("tb") and not list((root / folder).rglob("test_*.py")):
        folder = folder.parent
    if folder == Path("tb"):
        folder = folder / "system"
    own = folder / f"test_{source.stem}.py"
    return [str(own), str(folder)] if (root / own).exists() else [str(folder)]


def _commit_marks(root):
    """The marks by which `make test` selects."""
    return re.search(r'^test:.*\n(?:\t.*\n)*?\t.*pytest.* -m "([^"]*)"', (root / "Makefile").read_text(), re.M)[1]


def _run(tree, tests, options, limit, **environment):
    """Run tests until the first failure: what failed, empty if nothing did, and the seconds."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "-p", "no:cacheprovider", *options, *tests]
    # Python recognises stale bytecode by the file's size and second, which a bug may leave as they are.
    environment = {**os.environ, "PYTHONPATH": str(tree.resolve()), "PYTHONHASHSEED": "0",
                   "PYTHONDONTWRITEBYTECODE": "1", **environment}
    begin = time.monotonic()
    with subprocess.Popen(command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, start_new_session=True) as process:
        try:
            output = process.communicate(timeout=limit)[0]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return f"{NO_END} {limit:g} s", limit
    if process.returncode not in (0, NONE_SELECTED, *NOTICED):
        raise click.ClickException(f"no such tests: {' '.join(tests)}\n{output[-2000:]}")
    first = re.search(r"^(?:FAILED|ERROR) (\S.*?)(?: - |$)", output, re.M)
    noticed = process.returncode in NOTICED
    return ("" if not noticed else first[1] if first else UNNAMED), round(time.monotonic() - begin, 1)


def _git(*words, where=Path()):
    return subprocess.run(["git", "-C", where, *words], check=True, text=True, capture_output=True).stdout.strip()


def _reset(tree, commit):
    """Make the worktree ``tree`` that of a commit; what tests built there before stays."""
    if not tree.exists():
        _git("worktree", "prune")
        _git("worktree", "add", "--detach", tree, commit)
    _git("checkout", "--force", "--detach", commit, where=tree)


def _page(bugs, state):
    done = [(bug, state[bug["id"]]) for bug in bugs.values() if bug["id"] in state]
    rows = [f"{sum(bool(one['by']) for _, one in done)} of {len(done)} killed; {len(bugs)} in the list.", "",
            "| bug | class | file | what it does | killed by | s | commit |", "|---|---|---|---|---|---|---|"]
    rows += [f"| {bug['id']} | {bug['class']} | {bug['file']} | {' '.join(bug['does'].split())} "
             f"| {one['by'] or '**survived** ' + ' '.join(one['tests'])} | {one['seconds']} | {one['commit']} |"
             for bug, one in done]
    return "\n".join(rows) + "\n"


@click.command()
@click.argument("listed", metavar="LIST", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--ids", help="Inject only the bugs with these ids, separated by commas, even if they have a result.")
@click.option("--tests", multiple=True, help="Run these tests, in this order.  [default: each bug's own, its folder's]")
@click.option("--whole", is_flag=True, help="Then run tb/system, then all other tests of a commit.")
@click.option("--options", default="", help="Add options of pytest, for example '-n 2'.")
@click.option("--limit", type=float, default=3600, help="Kill tests that still run after this many seconds.")
def main(listed, ids, tests, whole, options, limit):
    """Inject the bugs of LIST that no test has killed yet, and write a table to out/bench/ under the name of the list.

    Results so far stay in build/bugs, so a run that was stopped continues. Bugs whose text is gone are reported at the
    end; the exit code is then 1.
    """
    bugs, name = read_list(listed), listed.stem
    chosen = ids.split(",") if ids else list(bugs)
    if unknown := [bug_id for bug_id in chosen if bug_id not in bugs]:
        raise click.UsageError(f"--ids: {listed} has no bug {', '.join(unknown)}")
    tree, commit = BUILD / name, _git("rev-parse", "--short", "HEAD")
    _reset(tree, commit)
    record = BUILD / f"{name}.json"
    state = json.loads(record.read_text()) if record.exists() else {}
    options, todo, stale, passes = ["-m", _commit_marks(tree), *options.split()], {}, [], set()
    for bug_id in chosen:
        near = list(tests) or near_tests(bugs[bug_id]["file"], tree)
        ran, known = list(dict.fromkeys([*near, *(WHOLE if whole else [])])), state.get(bug_id)
        try:
            apply(bugs[bug_id], tree, write=False)
        except (ValueError, OSError) as error:
            stale.append(str(error))
            continue
        if ids or not (known and (known["by"] or known["tests"] == ran)):
            todo[bug_id] = ran
    for bug_id, ran in todo.items():
        known = state.get(bug_id, {})
        done = known["tests"] if known.get("commit") == commit and not ids else []
        by, seconds = "", known["seconds"] if done else 0
        for group in ran[len(done):]:
            apply(bugs[bug_id], tree)
            # The compiler's cache of a function does not see changes of functions in other files that it calls.
            is_compiled = "@compiled" in (tree / bugs[bug_id]["file"]).read_text()
            kernels = {"NUMBA_CACHE_DIR": str((BUILD / "kernels" / bug_id).resolve())} if is_compiled else {}
            try:
                by, spent = _run(tree, [group, *(f"--ignore={one}" for one in done)], options, limit, **kernels)
            finally:
                _reset(tree, commit)
            seconds, done = round(seconds + spent, 1), [*done, group]
            killer = by if ".py" in by else group
            if by and killer not in passes:
                if failing := _run(tree, [killer], options, limit)[0]:
                    raise click.ClickException(f"{failing} fails without a bug")
                passes.add(killer)
            state[bug_id] = {"by": by, "seconds": seconds, "tests": done, "commit": commit}
            record.write_text(json.dumps(state, indent=1))
            if by:
                break
        click.echo(f"{bug_id}: {f'killed by {by}' if by else 'SURVIVED'} in {seconds} s")
        page = Path("out") / "bench" / f"{name}.md"
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(_page(bugs, state))
    if stale:
        raise click.ClickException("\n".join([f"{len(stale)} of {len(bugs)} bugs do not fit their files:", *stale]))
