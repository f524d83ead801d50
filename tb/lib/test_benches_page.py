"""The testbench of docs/benches.md runs, and notices what takes a cycle more and what holds an item less."""

import re
from itertools import pairwise
from pathlib import Path

import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

PAGE = (Path(__file__).parents[2] / "docs" / "benches.md").read_text()


@pytest.fixture
def bench():
    block = re.search(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)[1]
    assert len(block.splitlines()) <= 20
    names = {"__name__": "page"}
    exec(block, names)
    return names["TestSkidBuffer"]


def test_it_runs(bench):
    bench().test_in_amaranth({})


class Wrong(wiring.Component):
    """Units one after the other, which claim to be a skid buffer."""

    __doc__ = SkidBuffer.__doc__
    latency = 1

    def __init__(self, shape, make):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})
        self._units = make(shape)

    def elaborate(self, platform):
        m = Module()
        m.submodules += self._units
        for one, following in pairwise(self._units):
            wiring.connect(m, one.o, following.i)
        wiring.connect(m, wiring.flipped(self.i), self._units[0].i)
        wiring.connect(m, self._units[-1].o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize(("make", "message"), [
    (lambda shape: [SkidBuffer(shape), SkidBuffer(shape)], "o: item 0 of 100 is transferred in cycle 5, not 4"),
    (lambda shape: [Queue(shape, depth=1)], "i: item 1 of 100 is transferred in cycle 5, not 4")],
    ids=["a cycle late", "an item less"])
def test_a_wrong_cycle_is_noticed(bench, monkeypatch, make, message):
    monkeypatch.setattr(bench, "make", lambda self, config: Wrong(self.arguments["shape"], make))
    monkeypatch.setattr(bench, "formula", {"bypass": False})
    with pytest.raises(AssertionError, match=f"^{message}$"):
        bench().test_in_amaranth({})
