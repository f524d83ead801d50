"""Searches for garbage are what they were before, whatever happens."""

import gc

import pytest

from golden.base.without_collection import without_collection


@pytest.mark.parametrize("enabled", [True, False])
def test_searches_go_on_as_before(enabled):
    before = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        with pytest.raises(ZeroDivisionError), without_collection():
            _fail()
        assert gc.isenabled() == enabled
    finally:
        (gc.enable if before else gc.disable)()


def _fail():
    with without_collection():
        pass
    # What has ended within it begins none.
    assert not gc.isenabled()
    return 1 / 0
