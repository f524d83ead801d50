"""Rules of every run of tests: none is skipped, tests that share what is expensive to make run in one process,
SEED in the environment replays what a run has drawn, NIGHTS=10 has campaigns draw ten times as much, and a run says how
many tests each folder has.

Cases that need Icarus Verilog have the mark ``icarus``. Where it is not installed they are left out and counted; with
ICARUS=required in the environment the run fails instead.
"""

import gc
import os
import shutil
from collections import Counter

import pytest

_SHARED = ("module", "session")
_skipped: list[str] = []
# Tests of each folder, and Icarus cases that are left out: of this process, and what the last worker has sent.
_collected: Counter = Counter()
_left_out: list[int] = [0]


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Pass the run's seed to Hypothesis."""
    for name, least in (("SEED", 0), ("NIGHTS", 1)):
        if (value := os.environ.get(name)) is not None and not (value.isdecimal() and int(value) >= least):
            raise pytest.UsageError(f"{name} must be an integer of at least {least}, not {value!r}")
    if "SEED" in os.environ:
        config.option.hypothesis_seed = int(os.environ["SEED"])
    if os.environ.get("ICARUS") == "required" and shutil.which("iverilog") is None:
        raise pytest.UsageError("Icarus Verilog is not installed: apt-get install iverilog")


def pytest_report_header():
    """The seed with which the run can be repeated."""
    return f"SEED={os.environ['SEED']}" if "SEED" in os.environ else "the same seed and examples as in every run"


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected stays to the end: no search for garbage, now or later, has to walk through it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


# Before pytest-xdist, which reads the marks in the same hook.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests that share a fixture of their module stay in one of pytest-xdist's processes (``--dist loadgroup``)."""
    for item in items:
        fixtures = [one for found in item._fixtureinfo.name2fixturedefs.values() for one in found]
        shares = any(one.scope in _SHARED and one.func.__module__ == item.module.__name__ for one in fixtures)
        if shares and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.module.__name__))


class _Selection:
    """What remains when the marks have selected."""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config, items):
        """Leave out what needs Icarus where it is missing, and count the rest by folder."""
        if shutil.which("iverilog") is None:
            left_out = [item for item in items if item.get_closest_marker("icarus")]
            items[:] = [item for item in items if not item.get_closest_marker("icarus")]
            config.hook.pytest_deselected(items=left_out)
            _left_out[0] = len(left_out)
        _collected.update(item.nodeid.split("/")[1] for item in items if "/" in item.nodeid)


def pytest_sessionstart(session):
    """Register what must come behind the selection by marks."""
    session.config.pluginmanager.register(_Selection())


def pytest_runtest_logreport(report):
    """Record the tests that are skipped, or expected to fail."""
    if report.skipped:
        _skipped.append(report.nodeid)


# Of a module that is skipped no test is collected.
pytest_collectreport = pytest_runtest_logreport


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Fail a run with skipped tests: they find nothing. A worker sends its counts."""
    if _skipped and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["counts"] = [dict(_collected), _left_out[0]]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Each worker has collected all tests: any one's counts are the run's."""
    if "counts" in getattr(node, "workeroutput", {}):
        _collected.clear()
        counts, _left_out[0] = node.workeroutput["counts"]
        _collected.update(counts)


def pytest_terminal_summary(terminalreporter):
    """Print the tests of each folder, what was left out, and why the run fails."""
    if len(_collected) > 1:
        terminalreporter.write_line("tests: " + ", ".join(f"{name} {_collected[name]}" for name in sorted(_collected)))
    if _left_out[0]:
        terminalreporter.write_line(f"left out, Icarus Verilog is not installed: {_left_out[0]} tests")
    if _skipped:
        terminalreporter.write_line(f"error: skipped tests: {len(_skipped)}; none may be", red=True)
