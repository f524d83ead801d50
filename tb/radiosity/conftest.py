"""Machines whose kernels Python runs."""

from contextlib import nullcontext

import pytest

from tb.golden.machines.interpreted import interpreted_kernels


@pytest.fixture
def interpreted(request):
    """`interpreted_kernels`, but for the nightly's tests, which run longer."""
    with nullcontext() if request.node.get_closest_marker("nightly") else interpreted_kernels():
        yield
