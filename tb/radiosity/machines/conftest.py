"""Tests of simulated machines run in one process: the others need not compile the same simulators beside it."""

import os
from pathlib import Path

import pytest

from tb.radiosity.machines.interpreted import interpreted

__all__ = ["interpreted"]


# Before pytest-xdist, which reads the marks in the same hook.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Keep the tests of this folder in one of pytest-xdist's processes (``--dist loadgroup``)."""
    # As text: building the parents of each test's path takes longer than to collect the folder.
    folder = f"{Path(__file__).parent}{os.sep}"
    for item in items:
        if str(item.path).startswith(folder):
            item.add_marker(pytest.mark.xdist_group("machines"))
