"""A context in which simulations print what they cover."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

from amaranth.hdl import Fragment

from tb.coverage.arms import add_arms
from tb.coverage.toggles import add_toggles

__all__ = ["reported"]

ROOT = Path(__file__).parents[2]


@contextmanager
def reported(folder: Path = ROOT / "hw") -> Iterator[tuple[set[str], set[str]]]:
    """A context in which simulations, of Amaranth and of exported Verilog, print what they cover when they first do.

    Parameters
    ----------
    folder
        Of components in files below it.

    Yields
    ------
    The arms and the toggles of all components that have been elaborated, see `tb.coverage.arms` and
    `tb.coverage.toggles`.
    """
    arms: set[str] = set()
    bits: set[str] = set()
    original = Fragment.prepare

    def prepare(self, *arguments, **given):
        for fragment in _all(self):
            # The marks of arms are registers too.
            add_toggles(fragment, folder, bits)
            add_arms(fragment, folder, arms)
        return original(self, *arguments, **given)

    with mock.patch.object(Fragment, "prepare", prepare):
        yield arms, bits


def _all(fragment):
    """A fragment and all below it."""
    yield fragment
    for inner, *_ in fragment.subfragments:
        yield from _all(inner)
