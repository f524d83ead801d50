"""Tests of simulated machines run in one process: the others need not compile the same simulators beside it."""

from contextlib import nullcontext
from pathlib import Path

import pytest

from tb.golden.machines.interpreted import interpreted_kernels


# Before pytest-xdist, which reads the marks in the same hook.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Keep the tests of this folder in one of pytest-xdist's processes (``--dist loadgroup``)."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("machines"))


@pytest.fixture
def interpreted(request):
    """`interpreted_kernels`, but for the nightly's tests, which run longer."""
    with nullcontext() if request.node.get_closest_marker("nightly") else interpreted_kernels():
        yield
