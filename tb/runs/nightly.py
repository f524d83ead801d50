"""Run shards of the nightly and enter each into the ledger. Their Icarus cases must run."""

import hashlib
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable
from datetime import datetime
from pathlib import Path
from xml.etree import ElementTree

from tb.runs.ledger import LEDGER, Entry, Ledger
from tb.runs.shard import MINUTES, READERS, Shard
from tb.runs.versions import versions

__all__ = ["commit_of", "counts", "cpu_seconds", "end", "inputs_of", "run_shards"]

_OURS = re.compile(r"\btb(?:[./]\w+)+")


def commit_of(folder: Path) -> str:
    """The hash of the commit that is checked out, and ``+`` if files but the ledger differ from it."""
    changed = _git(folder, "status", "--porcelain", "--", ".", f":(exclude){LEDGER}")
    return _git(folder, "rev-parse", "HEAD").strip() + ("+" if changed else "")


def inputs_of(folder: Path, given: Iterable[Shard]) -> dict[str, str]:
    """By shard, a digest of all files of a commit that it may depend on; empty if files differ from the commit.

    These are all but the ledger, the changelog, Python files of ``tb`` that the shard's tests neither import nor name,
    directly or through others, and pages that no module of its folder names. So a shard that is green stays so where
    other tests or pages alone are mended, and for the commit that records it.
    """
    if commit_of(folder).endswith("+"):
        return {shard.name: "" for shard in given}
    files = {Path(line.split("\t")[1]): line for line in _git(folder, "ls-tree", "-r", "HEAD").splitlines()}
    for path in (LEDGER, "CHANGELOG.md"):
        files.pop(Path(path), None)
    ours = {path for path in files if path.parts[0] == "tb" and path.suffix == ".py"}
    leads = _leads(folder, ours)

    def digest(shard):
        room = shard.name.split("/")[0]
        own = {path for path in ours if path.parts[1] == room and not path.name.startswith("test_")}
        text = "".join(path.read_text() for path in (folder / "tb" / room).rglob("*.py"))
        reached = ours if room in READERS else _reached(
            leads, {*own, *(path.relative_to(folder) for path in shard.files)})
        foreign = {path for path in files if _is_page(path) and path.name not in text and room not in READERS}
        return hashlib.sha256("\n".join(line for path, line in files.items() if path not in foreign | ours - reached)
                              .encode()).hexdigest()[:16]

    return {shard.name: digest(shard) for shard in given}


def _leads(folder, ours):
    """For each of our files those that it imports or names in a string; a package stands for its modules."""
    places = defaultdict(set)
    for path in ours:
        places[path.with_suffix("")].add(path)
        if not path.name.startswith("test_"):
            places[path.parent].add(path)

    def named(name):
        steps = re.split("[./]", name)
        return next((places[place] for end in range(len(steps), 0, -1) if (place := Path(*steps[:end])) in places), ())

    return {path: set().union(*map(named, set(_OURS.findall((folder / path).read_text())))) for path in ours}


def _reached(leads, begin):
    """The files that some lead to, and what pytest reads in any case."""
    found, todo = set(), {*begin, *(path for path in leads if path.name in ("__init__.py", "conftest.py"))}
    while todo:
        found.add(path := todo.pop())
        todo |= leads[path] - found
    return found


def _is_page(path):
    """Whether a file is of the documentation; its figures are records, which code reads."""
    return path.suffix == ".md" or (path.parts[0] == "docs" and path.parts[1] != "figures")


def _git(folder, *words):
    return subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, check=True).stdout


def counts(report: Path) -> tuple[int, int, int]:
    """Tests that passed, that failed and that were skipped, of a JUnit report; nothing if there is none."""
    if not report.exists():
        return 0, 0, 0
    suites = list(ElementTree.parse(report).getroot().iter("testsuite"))
    total, failures, errors, skipped = (sum(int(suite.get(name, "0")) for suite in suites)
                                        for name in ("tests", "failures", "errors", "skipped"))
    return total - failures - errors - skipped, failures + errors, skipped


def run_shards(root: Path, given: Iterable[Shard], ledger: Ledger, *, seed: int, report: Callable[[Entry], object],
               minutes: float | None = None, most: float = MINUTES, processes: int = 2) -> bool:
    """Run shards one after the other, whatever fails, and enter each.

    Parameters
    ----------
    root
        The checkout.
    given
        The shards.
    ledger
        Gets their entries.
    seed
        What their tests draw from.
    report
        Is given each entry.
    minutes
        No shard begins later than this.
    most
        A shard is ended after this many minutes.
    processes
        Tests that run at once; 0: in pytest's own process.

    Returns
    -------
    Whether all ran and are green.
    """
    begin, is_green = time.monotonic(), True
    for shard in given:
        if minutes is not None and time.monotonic() - begin > 60 * minutes:
            return False
        entry = _run(root, shard, seed, most, processes)
        ledger.add(entry)
        is_green &= entry.result == "green"
        report(entry)
    return is_green


def _run(root, shard, seed, most, processes):
    """The entry of a run of one shard."""
    report = root / "out" / "nightly" / f"{shard.name.replace('/', '-')}.xml"
    report.parent.mkdir(parents=True, exist_ok=True)
    report.unlink(missing_ok=True)
    commit, inputs = commit_of(root), inputs_of(root, [shard])[shard.name]
    began, begin, used = datetime.now(), time.monotonic(), cpu_seconds()
    command = [sys.executable, "-m", "pytest", "-n", str(processes), "--dist", "loadgroup", "-q",
               f"--junitxml={report}", *(str(path.relative_to(root)) for path in shard.files)]
    process = subprocess.Popen(command, cwd=root, start_new_session=True,
                               env={**os.environ, "SEED": str(seed), "ICARUS": "required"})
    try:
        code, result = process.wait(60 * most), "red"
    except subprocess.TimeoutExpired:
        code, result = None, "late"
    finally:
        end(process)
    passed, failed, skipped = counts(report)
    if code == 0 and passed and not failed and not skipped:
        result = "green"
    return Entry(
        shard=shard.name, commit=commit, inputs=inputs, seed=seed, versions=versions(),
        began=began.isoformat("T", "seconds"), wall=round(time.monotonic() - begin, 1),
        cpu=round(cpu_seconds() - used, 1), passed=passed, failed=failed, skipped=skipped, result=result)


def end(process: subprocess.Popen, grace: float = 60) -> None:
    """End a run of pytest that leads its own group of processes, so that it still writes its report if it can.

    Parameters
    ----------
    process
        pytest.
    grace
        Seconds that it has for its report.
    """
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(grace)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def cpu_seconds():
    """CPU seconds of all programs that ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
