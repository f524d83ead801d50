"""A plugin of pytest: the arms that the tests' simulations enter, of all that they elaborate.

``pytest -p tb.coverage.plugin -n 2 --dist loadgroup -m "not nightly" tb/icu`` writes out/coverage/arms.json.
"""

import contextlib
import json
from pathlib import Path
from unittest import mock

import pytest

from tb.coverage.arms import MARK, reported
from tb.lib import runner

OUTPUT = Path("out") / "coverage" / "arms.json"
_entered: set[str] = set()
_known: set[str] = set()
_contexts = contextlib.ExitStack()


def pytest_configure():
    """Let all simulations report their arms."""
    global _known
    _known = _contexts.enter_context(reported())
    _contexts.enter_context(mock.patch.object(runner.Simulation, "run", _run(runner.Simulation.run)))


def _run(original):
    """A run under cocotb has a log; what it reports is printed, as the other simulators do."""
    def run(self, module, tests, name, *arguments, **given):
        failed = original(self, module, tests, name, *arguments, **given)
        log = (runner.WAVES if self._waves else runner.BUILD / "results") / name / "log.txt"
        if log.exists():
            print(*sorted(_marks(log.read_text())), sep="\n")  # noqa: T201
        return failed
    return run


def _marks(text):
    return {line[line.index(MARK):] for line in text.splitlines() if MARK in line}


def pytest_runtest_logreport(report):
    """Take note of what a test has printed."""
    if report.when == "teardown":
        _entered.update(line.removeprefix(MARK) for line in _marks(report.capstdout))


def pytest_sessionfinish(session):
    """A worker sends what it has elaborated."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["arms"] = sorted(_known)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Of a worker: what it has elaborated."""
    _known.update(getattr(node, "workeroutput", {}).get("arms", ()))


def pytest_unconfigure(config):
    """Write the file."""
    _contexts.close()
    if not hasattr(config, "workeroutput"):
        OUTPUT.parent.mkdir(parents=True, exist_ok=True)
        OUTPUT.write_text(json.dumps({"elaborated": sorted(_known), "entered": sorted(_entered & _known)}, indent=0))
