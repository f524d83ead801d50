"""Routers and networks against the model: all wires, cycle by cycle."""

from itertools import chain, repeat

import cocotb
import numpy as np
from amaranth.hdl import Cat, Module, Mux, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import RisingEdge

from golden.engine.noc.link_words import link_words
from golden.engine.noc.network import Arrivals, Packets
from radiosity.flow.verilog.export import verilog_of
from tb.lib.clocking import start
from tb.lib.runner import BUILD, options, simulate

__all__ = ["Words", "replay", "script"]


class Words(wiring.Component):
    """A component with links, its wires in two words.

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


# A word of ``vectors`` per cycle: whether the component is reset, whether its wires are compared, what it is given,
# and what it must answer. Between clock edges the wires are compared, and what is given changes.
_BENCH = """
module top(input clk, input rst, output reg [31:0] cycle, compared, output reg differs, output reg done);
  reg [{high}:0] vectors [0:{last}];
  reg reset = 1;
  reg [{bits} - 1:0] given = 0;
  wire [{bits} - 1:0] came;
  wire [{high}:0] now = vectors[cycle];
  wire compares = now[{high} - 1];
  initial $readmemh("{path}", vectors);
  words words(.clk(clk), .rst(reset), .i(given), .o(came));
  always @(negedge clk)
    if (rst) begin
      cycle <= 0; compared <= 0; differs <= 0; done <= 0; reset <= 1; given <= 0;
    end else if (!differs && !done) begin
      if (compares && came !== now[{bits} - 1:0]) differs <= 1;
      else begin
        reset <= now[{high}];
        given <= now[{high} - 2:{bits}];
        done <= cycle == {last};
        cycle <= cycle + 1;
        if (compares) compared <= compared + 1;
      end
    end
endmodule
"""


def replay(component, scripts: list[dict], *, simulator: str, name: str) -> None:
    """All scripts, one after the other, each after a reset within the one before: of each a part first, then all.

    Parameters
    ----------
    scripts
        ``given`` and ``required``, a word per cycle.
    """
    words = Words(component)
    bits = len(words.i)
    vectors = list(chain.from_iterable(_vectors(one, bits) for one in scripts))
    path = (BUILD / "vectors" / f"{name}-{simulator}.hex").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(f"{word:x}" for word in vectors))
    simulate(verilog_of(words, "words") + _BENCH.format(bits=bits, high=2 * bits + 1, last=len(vectors) - 1, path=path),
             "tb.noc.replay", ("as_the_model_says",), simulator=simulator, name=f"{name}-{simulator}",
             visible=("clk", "rst", "cycle", "compared", "differs", "done"), cycles=len(vectors) + 100,
             compared=sum(word >> 2 * bits & 1 for word in vectors))


def _vectors(one, bits):
    """Two cycles of reset and a third of a script, then the same and all of it."""
    compares = 1 << 2 * bits
    for cycles in (len(one["given"]) // 3, len(one["given"])):
        yield from repeat(compares << 1, 2)
        yield 0
        for given, required in zip(one["given"][:cycles], one["required"][:cycles], strict=True):
            yield compares | given << bits | required


@cocotb.test()
async def as_the_model_says(dut):
    """Every wire has the model's value in every cycle; also after a reset in flight."""
    await start(dut, cycles=options()["cycles"])
    while not dut.done.value:
        await RisingEdge(dut.clk)
        assert not dut.differs.value, f"wires differ in cycle {int(dut.cycle.value)}"
    assert int(dut.compared.value) == options()["compared"], "the vectors were not read"
