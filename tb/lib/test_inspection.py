import gc
import warnings

import pytest
from amaranth.hdl import Fragment

from golden.base.errors import InputError
from hw.lib.inspection import inspect
from hw.lib.queue import Queue


def look(queue):
    return len(queue.o.payload)


def refuse(queue):
    raise InputError(f"{queue!r} is too small")


@pytest.mark.parametrize("looks", [look, refuse])
def test_what_is_only_looked_at_leaves_no_warning(looks):
    """Nor where the look fails, though the failure's frames hold the component."""
    # Amaranth warns of nothing before something is elaborated.
    Fragment.get(Queue(7, depth=4), None)
    gc.collect()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = inspect(lambda: Queue(7, depth=4), looks)
        except InputError:
            found = None
        gc.collect()
    assert not caught
    assert found == (7 if looks is look else None)
