"""A worktree of a commit, in which bugs are injected and tests run."""

import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from golden.base.errors import InputError
from tb.bugs.drawing import Bug
from tb.bugs.guards import LARGE, SMALL

__all__ = ["Outcome", "Tree", "cpu_seconds"]

# Rules of ruff that find faults; the others are about style, which a bug's condition does not have.
_FAULTS = "F,B,E9,PLE"
# Exit codes of pytest: all passed or none selected; failed, or stopped by errors of collection.
_PASSED, _FAILED, _USAGE = (0, 5), (1, 2, 3), 4
# Seconds after which a run without any work has come to a deadlock.
_IDLE = 240
_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Outcome:
    """Of a run of tests.

    Parameters
    ----------
    failed
        Tests that failed, or were running when time was over.
    seconds
        Of the CPU, children included.
    ended
        Whether all ran within the limit.
    """

    failed: tuple[str, ...]
    seconds: float
    ended: bool


def cpu_seconds(session: int) -> float:
    """CPU seconds of all processes of a session, with those of their children that have ended."""
    total = 0
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        if int(fields[3]) == session:
            total += sum(map(int, fields[11:15]))
    return total / _TICKS


class Tree:
    """A worktree.

    Parameters
    ----------
    path
        Where it is made; what tests build there stays for the next bug.
    commit
        Of the repository of the current folder.
    """

    def __init__(self, path: Path, commit: str):
        self.path = path.resolve()
        if not self.path.exists():
            subprocess.run(["git", "worktree", "prune"], check=True)
            subprocess.run(["git", "worktree", "add", "--quiet", "--detach", self.path, commit], check=True)
        subprocess.run(["git", "-C", self.path, "checkout", "--quiet", "--force", "--detach", commit], check=True)
        self._clean: dict[str, bytes] = {}

    def inject(self, *bugs: Bug) -> None:
        """Put bugs of different files in, in place of those before."""
        for path in [*self._clean]:
            self._write(path, self._clean.pop(path))
        for bug in bugs:
            file = self.path / bug.path
            self._clean[bug.path] = file.read_bytes()
            self._write(bug.path, bug.text.encode())

    def _write(self, path, data):
        """Compiled files are recognised as old by the second of a change."""
        file = self.path / path
        time_before = int(file.stat().st_mtime)
        file.write_bytes(data)
        os.utime(file, (time_before + 2, time_before + 2))

    def fault(self, bug: Bug) -> str:
        """Why an injected bug does not count: what ruff, Python or Amaranth says; "" if it does."""
        module = bug.path[:-3].replace("/", ".").removesuffix(".__init__")
        commands = {"lint": [sys.executable, "-m", "ruff", "check", "--quiet", "--no-cache", "--select", _FAULTS,
                             bug.path],
                    "import": [sys.executable, "-W", "error::SyntaxWarning", "-c", f"import {module}"]}
        if bug.path.startswith("hw/"):
            preset = LARGE if bug.guard == "configuration" else SMALL
            commands["elaboration"] = [sys.executable, "-W", "error::SyntaxWarning", "-m", "tb.bugs.elaboration",
                                       preset]
        for name, command in commands.items():
            done = subprocess.run(command, cwd=self.path, env=self._environment(), capture_output=True, text=True,
                                  check=False)
            if done.returncode:
                return f"{name}: {(done.stdout + done.stderr).strip().splitlines()[-1:]}"
        return ""

    def run(self, tests: list[str], *, marks: str = "", limit: float, most: int = 1, without: tuple = ()) -> Outcome:
        """Run tests until some have failed.

        Parameters
        ----------
        tests
            Paths or names.
        marks
            By which they are selected.
        limit
            CPU seconds.
        most
            Failures after which it ends.
        without
            Files and names of tests that do not run.

        Raises
        ------
        InputError
            pytest knows no such tests.
        """
        left = [f"--{'deselect' if '::' in one else 'ignore'}={one}" for one in without]
        command = [sys.executable, "-m", "pytest", "-v", "-rE", "--tb=no", "-p", "no:cacheprovider",
                   f"--maxfail={most}", *(["-m", marks] if marks else []), *left, *tests]
        log = self.path / "build" / "bugs.log"
        log.parent.mkdir(exist_ok=True)
        with log.open("w") as output:
            process = subprocess.Popen(command, cwd=self.path, env=self._environment(), stdout=output,
                                       stderr=subprocess.STDOUT, start_new_session=True)
            try:
                spent, ended, process.returncode = self._wait(process.pid, limit)
            except BaseException:
                os.killpg(process.pid, signal.SIGKILL)
                raise
        text = log.read_text(errors="replace")
        if not ended:
            running = re.findall(r"^(tb/\S+\.py::.*?)(?: (?:PASSED|FAILED|ERROR|XFAIL).*)?$", text, re.M)
            return Outcome(tuple(one.strip() for one in running[-1:]), spent, ended)
        if process.returncode == _USAGE and "Error while loading conftest" in text:
            return Outcome(tuple(tests[:1]), spent, ended)
        if process.returncode not in (*_PASSED, *_FAILED):
            raise InputError(f"pytest ends with {process.returncode}: {text[-2000:]}")
        failed = re.findall(r"^(tb/\S+\.py::.+?) (?:FAILED|ERROR)(?: |$)", text, re.M)
        failed += re.findall(r"^ERROR (tb/\S+\.py)(?: |$)", text, re.M)
        if process.returncode in _FAILED and not failed:
            failed = tests[:1]
        return Outcome(tuple(dict.fromkeys(failed)), spent, ended)

    def _wait(self, pid, limit):
        """CPU seconds of a process, whether it ended by itself, and how."""
        spent = moved = 0.0
        since = time.monotonic()
        while True:
            done, status, usage = os.wait4(pid, os.WNOHANG)
            if done:
                return round(usage.ru_utime + usage.ru_stime, 1), True, os.waitstatus_to_exitcode(status)
            spent = cpu_seconds(pid)
            if spent > moved + 0.5:
                moved, since = spent, time.monotonic()
            if spent > limit or time.monotonic() - since > _IDLE:
                os.killpg(pid, signal.SIGKILL)
                os.wait4(pid, 0)
                return round(spent, 1), False, -signal.SIGKILL
            time.sleep(0.5)

    def _environment(self):
        return {**os.environ, "PYTHONPATH": str(self.path), "PYTHONHASHSEED": "0", "PYTHONUNBUFFERED": "1"}
