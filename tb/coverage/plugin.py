"""A plugin of pytest: what the tests' simulations cover, of all that they elaborate.

``pytest -p tb.coverage.plugin -n 2 --dist loadgroup -m "not nightly" tb/icu`` writes out/coverage/covered.json.
"""

import contextlib
import json
from pathlib import Path
from unittest import mock

import pytest

from tb.coverage import arms, toggles
from tb.coverage.reported import reported
from tb.lib import runner

OUTPUT = Path("out") / "coverage" / "covered.json"
# Arms and toggles: all of what has been elaborated, and what simulations have printed.
_known: tuple[set[str], set[str]] = (set(), set())
_covered: tuple[set[str], set[str]] = (set(), set())
_contexts = contextlib.ExitStack()


def pytest_configure():
    """Let all simulations report what they cover."""
    global _known
    _known = _contexts.enter_context(reported())
    _contexts.enter_context(mock.patch.object(runner.Simulation, "run", _run(runner.Simulation.run)))


def _run(original):
    """A run under cocotb has a log; what it reports is printed, as the other simulators do."""
    def run(self, module, tests, name, *arguments, **given):
        failed = original(self, module, tests, name, *arguments, **given)
        log = (runner.WAVES if self._waves else runner.BUILD / "results") / name / "log.txt"
        if log.exists():
            text = log.read_text()
            print(*sorted(_marks(text, arms.MARK) | _marks(text, toggles.MARK)), sep="\n")  # noqa: T201
        return failed
    return run


def _marks(text, mark):
    return {line[line.index(mark):] for line in text.splitlines() if mark in line}


def pytest_runtest_logreport(report):
    """Take note of what a test has printed."""
    if report.when == "teardown":
        _covered[0].update(line.removeprefix(arms.MARK) for line in _marks(report.capstdout, arms.MARK))
        for line in _marks(report.capstdout, toggles.MARK):
            _covered[1].update(toggles.toggles(line.removeprefix(toggles.MARK)))


def pytest_sessionfinish(session):
    """A worker sends what it has elaborated."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["known"] = [sorted(one) for one in _known]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Of a worker: what it has elaborated."""
    for known, more in zip(_known, getattr(node, "workeroutput", {}).get("known", ()), strict=False):
        known.update(more)


def pytest_unconfigure(config):
    """Write the file."""
    _contexts.close()
    if not hasattr(config, "workeroutput"):
        OUTPUT.parent.mkdir(parents=True, exist_ok=True)
        OUTPUT.write_text(json.dumps(
            {name: {"elaborated": sorted(known), "covered": sorted(covered & known)}
             for name, known, covered in zip(("arms", "toggles"), _known, _covered, strict=True)}, indent=0))
