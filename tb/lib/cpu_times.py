"""A plugin of pytest: CPU seconds of each folder of tests, with those of the programs that the tests run.

``pytest -p tb.lib.cpu_times -n 2 --dist loadgroup -m "not nightly and not sim"`` writes out/cpu-times.csv. CPU time
depends less than wall time on what else the machine does. ``python -m tb.lib.cpu_times`` prints what each tenth of it
is for.
"""

import csv
import os
import sys
from collections import defaultdict
from pathlib import Path

import pytest

__all__ = ["tenths"]

OUTPUT = Path("out") / "cpu-times.csv"
_NAME = "cpu seconds"
_found: dict[str, list] = defaultdict(lambda: [0, 0.0])


def _used():
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    """Take the time before a test's first fixture."""
    item.user_properties.append((_NAME, _used()))
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Note the time since then in the last report of a test."""
    report = yield
    if call.when == "teardown":
        begin = next(value for name, value in item.user_properties if name == _NAME)
        report.user_properties = [(_NAME, _used() - begin)]
    return report


def pytest_runtest_logreport(report):
    """Add to the folder; with several workers only their controller does."""
    if report.when == "teardown" and "PYTEST_XDIST_WORKER" not in os.environ:
        row = _found[report.nodeid.partition("::")[0].rpartition("/")[0]]
        row[0] += 1
        row[1] += sum(value for name, value in report.user_properties if name == _NAME)


def pytest_sessionfinish():
    """Write the table."""
    if _found:
        OUTPUT.parent.mkdir(parents=True, exist_ok=True)
        rows = [f"{folder},{count},{seconds:.1f}" for folder, (count, seconds) in sorted(_found.items())]
        OUTPUT.write_text("\n".join(["folder,tests,cpu_seconds", *rows, ""]))


def tenths(seconds: dict[str, float]) -> str:
    """What each tenth of the time is for, as Markdown: folders by their seconds, the largest first.

    Parameters
    ----------
    seconds
        CPU seconds of each folder.
    """
    tenth, rows, end = sum(seconds.values()) / 10, [[] for _ in range(10)], 0.0
    for folder, spent in sorted(seconds.items(), key=lambda item: -item[1]):
        begin, end = end, end + spent
        for number, row in enumerate(rows):
            share = min(end, (number + 1) * tenth) - max(begin, number * tenth)
            if share >= 0.5:
                row.append(f"`{folder}` {share:.0f} s")
    return "\n".join(["| tenth | folders |", "|---|---|", *(
        f"| {number} | {', '.join(row)} |" for number, row in enumerate(rows, 1)), ""])


if __name__ == "__main__":
    with OUTPUT.open(newline="") as file:
        sys.stdout.write(tenths({row["folder"]: float(row["cpu_seconds"]) for row in csv.DictReader(file)}))
