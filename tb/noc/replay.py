"""Routers and networks against the model: all wires, cycle by cycle."""

import json
from itertools import islice
from pathlib import Path

import cocotb
import numpy as np
from amaranth.hdl import Cat, Module, Mux, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import FallingEdge

from golden.engine.noc.link_words import link_words
from golden.engine.noc.network import Arrivals, Packets
from tb.lib.clocking import reset, start
from tb.lib.runner import BUILD, options, simulate

__all__ = ["Words", "replay", "script"]


class Words(wiring.Component):
    """A component with links, its wires in two words: simulators are read once per cycle.

    Members
    -------
    i
        Per link ``valid``, the payload, and the credits that come back.
    o
        The same of the other direction; the payload is 0 while there is none.
    """

    def __init__(self, dut):
        self._dut = dut
        self._bits = 1 + len(Value.cast(dut.i[0].payload)) + len(dut.i_credit[0])
        super().__init__({"i": In(self._bits * len(dut.i)), "o": Out(self._bits * len(dut.i))})

    def elaborate(self, platform):
        """Wires only."""
        m = Module()
        m.submodules.dut = dut = self._dut
        out = []
        for k in range(len(dut.i)):
            m.d.comb += Cat(dut.i[k].valid, Value.cast(dut.i[k].payload), dut.i_credit[k]).eq(
                self.i.word_select(k, self._bits))
            sent = Value.cast(dut.o[k].payload)
            out.append(Cat(dut.o[k].valid, Mux(dut.o[k].valid, sent, 0), dut.o_credit[k]))
        m.d.comb += self.o.eq(Cat(out))
        return m


def script(generator: np.random.Generator, packets: Packets, arrivals: Arrivals, *, nodes: int, bits: int,
           channels: int) -> dict:
    """What a network is given, and what it must answer, with random data."""
    data = [int.from_bytes(generator.bytes((bits + 7) // 8)) & (1 << bits) - 1 for _ in arrivals.packet]
    given, required = link_words(packets, arrivals, data, nodes=nodes, bits=bits, channels=channels)
    return {"given": given.words, "required": required.words}


def replay(component, scripts: list[dict], *, simulator: str, name: str) -> None:
    """All scripts, one after the other, each after a reset within the one before.

    Parameters
    ----------
    scripts
        ``given`` and ``required``, a word per cycle.
    """
    path = (BUILD / "vectors" / f"{name}-{simulator}.json").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps([{part: [hex(word) for word in words] for part, words in one.items()}
                                for one in scripts]))
    simulate(Words(component), "tb.noc.replay", ("as_the_model_says",), simulator=simulator,
             name=f"{name}-{simulator}", visible=("clk", "rst", "i", "o"), script=str(path))


@cocotb.test()
async def as_the_model_says(dut):
    """Every wire has the model's value in every cycle; also after a reset in flight."""
    scripts = json.loads(Path(options()["script"]).read_text())
    dut.i.value = 0
    await start(dut, cycles=sum(len(one["given"]) for one in scripts) * 2 + 1000)
    edge = FallingEdge(dut.clk)
    for number, one in enumerate(scripts):
        given = [int(word, 16) for word in one["given"]]
        required = [int(word, 16) for word in one["required"]]
        # A part of it first, then a reset, then all of it.
        for cycles in (len(given) // 3, len(given)):
            await reset(dut)
            await edge
            for cycle, (word, expected) in enumerate(islice(zip(given, required, strict=True), cycles)):
                came = dut.o.value
                assert came.is_resolvable, f"script {number}: cycle {cycle} has unknown wires"
                assert int(came) == expected, f"script {number}, cycle {cycle}: {int(came) ^ expected:x} differs"
                dut.i.value = word
                await edge
            dut.i.value = 0
