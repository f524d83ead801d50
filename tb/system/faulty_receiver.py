"""Receivers of links that corrupt a flit after some resets, and a machine with them."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path

import pytest
from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring

from golden.engine.config import Config
from hw.engine import Engine
from hw.noc import network_interface
from hw.noc.link_receiver import LinkReceiver
from radiosity.flow.simulator import machine_library
from radiosity.flow.verilog.export import verilog_of

__all__ = ["FaultyReceiver", "faulty_machine"]

# Flits after a reset before the one that is corrupted.
BEFORE = 40


class FaultyReceiver(wiring.Component):
    """A `LinkReceiver` that corrupts a flit before the first reset of its network, one between the second and the third
    one, and so on.

    Parameters
    ----------
    faults
        What is corrupted, one after the other: ``data`` or ``last`` of a flit, or ``destination`` of a packet.
    given
        Parameters of `LinkReceiver`.
    """

    def __init__(self, *, faults: tuple[str, ...], **given):
        self._faults, self._receiver = faults, LinkReceiver(**given)
        super().__init__(self._receiver.signature)

    def elaborate(self, platform):
        """The receiver behind a link with faults."""
        m = Module()
        m.submodules.receiver = receiver = self._receiver
        # A reset of the units does not clear the number of resets.
        resets, ran = Signal(range(2 * len(self._faults) + 1), reset_less=True), Signal(reset_less=True)
        runs, count = Signal(), Signal(range(BEFORE + 2))
        m.d.sync += [runs.eq(1), ran.eq(runs)]
        with m.If(ran & ~runs & (resets != 2 * len(self._faults))):
            m.d.sync += resets.eq(resets + 1)
        given, flit = self.i, receiver.i.payload.flit
        m.d.comb += [receiver.i.valid.eq(given.valid), receiver.i.payload.eq(given.payload),
                     self.o_credit.eq(receiver.o_credit)]
        for inner, own in zip(receiver.o, self.o, strict=True):
            wiring.connect(m, inner, wiring.flipped(own))
        # The destination is in the lowest bits of a packet's first flit.
        is_next = Signal()
        m.d.comb += is_next.eq(given.valid & (count == BEFORE))
        with m.If(given.valid):
            m.d.sync += count.eq(Mux(count <= BEFORE, count + 1, count))
        for number, fault in enumerate(self._faults):
            with m.If(resets == 2 * number):
                if fault == "last":
                    with m.If(is_next):
                        m.d.comb += flit.last.eq(~given.payload.flit.last)
                else:
                    with m.If(is_next & (given.payload.flit.first | (fault == "data"))):
                        m.d.comb += flit.data[0].eq(~given.payload.flit.data[0])
                    if fault == "destination":
                        with m.If(is_next & ~given.payload.flit.first):
                            m.d.sync += count.eq(count)
        return m


def faulty_machine(config: Config, *faults: str) -> Path:
    """The library of a machine whose receivers are a `FaultyReceiver`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(network_interface, "LinkReceiver", partial(FaultyReceiver, faults=faults))
        # What the sources alone make is not what is kept for them.
        patch.setattr(machine_library, "top_verilog",
                      lambda one: verilog_of(Engine(config=one, black_boxes=True), "top"))
        patch.setattr(machine_library, "export_beside", lambda one: nullcontext())
        return machine_library.machine_library(config)
