"""Run shards of the nightly and enter each into the ledger. Their Icarus cases must run."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from xml.etree import ElementTree

from tb.runs.inputs import Inputs, commit_of, watched
from tb.runs.ledger import Entry, Ledger
from tb.runs.shard import MINUTES, Shard
from tb.runs.versions import versions

__all__ = ["begin", "counts", "cpu_seconds", "end", "run_shards"]

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
    start, is_green = time.monotonic(), True
    for shard in given:
        if minutes is not None and time.monotonic() - start > 60 * minutes:
            return False
        entry = _run(root, shard, seed, most, processes)
        ledger.add(entry)
        is_green &= entry.result == "green"
        report(entry)
    return is_green


def _run(root, shard, seed, most, processes):
    """The entry of a run of one shard."""
    report = root / "out" / "nightly" / f"{shard.name.replace('/', '-')}.xml"
    log = report.with_suffix(".reads")
    report.parent.mkdir(parents=True, exist_ok=True)
    report.unlink(missing_ok=True)
    log.unlink(missing_ok=True)
    commit, inputs = commit_of(root), Inputs(root, [shard])
    began, start, used = datetime.now(), time.monotonic(), cpu_seconds()
    command = [sys.executable, "-m", "pytest", "-n", str(processes), "--dist", "loadgroup", "-q",
               f"--junitxml={report}", *(str(path.relative_to(root)) for path in shard.files)]
    process = begin(command, root, watched({**os.environ, "SEED": str(seed), "ICARUS": "required"}, root, log))
    try:
        code, result = process.wait(60 * most), "red"
    except subprocess.TimeoutExpired:
        code, result = None, "late"
    finally:
        end(process)
    passed, failed, skipped = counts(report)
    if code == 0 and passed and not failed and not skipped:
        result = "green"
    reads = inputs.reads(log)
    return Entry(
        shard=shard.name, commit=commit, inputs=inputs.digest(shard.name, reads), reads=reads, seed=seed,
        versions=versions(),
        began=began.isoformat("T", "seconds"), wall=round(time.monotonic() - start, 1),
        cpu=round(cpu_seconds() - used, 1), passed=passed, failed=failed, skipped=skipped, result=result)


def begin(command: Sequence[str], folder: Path, environment: Mapping[str, str], **options) -> subprocess.Popen:
    """Begin a run of pytest that `end` can end: it leads a group of processes, and an interrupt reaches it.

    Parameters
    ----------
    command
        Program and arguments.
    folder
        Where it runs.
    environment
        All of its variables.
    options
        More arguments of `subprocess.Popen`.
    """
    # What a shell begins in the background ignores interrupts, and so does what that begins.
    return subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, **options,
                            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))


def end(process: subprocess.Popen, grace: float = 60) -> None:
    """End a run of pytest, so that it still writes its report if it can.

    Parameters
    ----------
    process
        As `begin` gives it.
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
