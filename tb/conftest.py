"""Rules of every run of tests: none is skipped, tests that share what is expensive to make run in one process, and
SEED in the environment replays what a run has drawn.
"""

import os

import pytest

_SHARED = ("module", "session")
_skipped: list[str] = []


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Pass the run's seed to Hypothesis."""
    if "SEED" in os.environ:
        config.option.hypothesis_seed = int(os.environ["SEED"])


def pytest_report_header():
    """The seed with which the run can be repeated."""
    return f"SEED={os.environ['SEED']}" if "SEED" in os.environ else "the same seed and examples as in every run"


# Before pytest-xdist, which reads the marks in the same hook.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests that share a fixture of their module stay in one of pytest-xdist's processes (``--dist loadgroup``)."""
    for item in items:
        fixtures = [one for found in item._fixtureinfo.name2fixturedefs.values() for one in found]
        shares = any(one.scope in _SHARED and one.func.__module__ == item.module.__name__ for one in fixtures)
        if shares and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.module.__name__))


def pytest_runtest_logreport(report):
    """Record the tests that are skipped."""
    if report.skipped and not hasattr(report, "wasxfail"):
        _skipped.append(report.nodeid)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Fail a run with skipped tests: they find nothing."""
    if _skipped and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    """Print why the run fails."""
    if _skipped:
        terminalreporter.write_line(f"error: skipped tests: {len(_skipped)}; none may be", red=True)
