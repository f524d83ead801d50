"""Views of waveforms: groups of streams with the fields of their payloads, names of states and values."""

from amaranth.hdl import Module, Mux
from amaranth.lib import data, enum, stream, wiring
from amaranth.lib.wiring import In, Out

from radiosity.flow.verilog.export import verilog_of
from tb.lib.bench_view import named_states, write_bench_view


class Kind(enum.Enum, shape=2):
    NEAR = 0
    FAR = 2


class Item(data.Struct):
    number: 5
    last: 1


class Inner(wiring.Component):
    """Goes to and fro between three states."""

    i: In(stream.Signature(Item))
    kind: Out(Kind)

    def elaborate(self, platform):
        m = Module()
        with m.FSM():
            for name, following in (("IDLE", "RUNS"), ("RUNS", "ENDS"), ("ENDS", "IDLE")):
                with m.State(name):
                    m.next = following
        m.d.sync += [self.i.ready.eq(~self.i.ready), self.kind.eq(Mux(self.i.payload.last, Kind.FAR, Kind.NEAR))]
        return m


class Outer(wiring.Component):
    """Holds the other one."""

    i: In(stream.Signature(Item))
    count: Out(3)

    def elaborate(self, platform):
        m = Module()
        m.submodules.inner = inner = Inner()
        wiring.connect(m, wiring.flipped(self.i), inner.i)
        m.d.sync += self.count.eq(self.count + 1)
        return m


def shown(tmp_path):
    """The lines of the view of a component with another one inside, and its folder."""
    with named_states():
        text = verilog_of(Outer(), "top")
    return write_bench_view(text, tmp_path / "dump.vcd").read_text().splitlines()


def test_a_stream_is_a_group_of_its_handshake_and_the_fields_of_its_payload(tmp_path):
    lines = shown(tmp_path)
    begin = lines.index("-i")
    assert [line for line in lines[begin:lines.index("-i", begin + 1)] if line.startswith("top.")] == [
        "top.i__valid", "top.i__ready", "top.i__payload[5:0]", "top.i__payload.last", "top.i__payload.number[4:0]"]


def test_modules_are_groups_and_the_outer_one_is_open(tmp_path):
    lines = shown(tmp_path)
    assert lines[lines.index("-top") - 1] == "@800200"
    assert lines[lines.index("-top.inner") - 1] == "@c00200"
    assert "top.count[2:0]" in lines[:lines.index("-top.inner")]
    assert "top.inner.kind[1:0]" in lines[lines.index("-top.inner"):]
    assert lines[0] == '[dumpfile] "dump.vcd"'


def test_states_and_enumerations_show_their_names_and_nothing_else_does(tmp_path):
    lines = shown(tmp_path)
    files = {lines[k + 1]: line.split(maxsplit=1)[1] for k, line in enumerate(lines) if line.startswith("^")}
    assert {signal: (tmp_path / file).read_text() for signal, file in files.items()} == {
        "top.inner.fsm_state[1:0]": "0 IDLE\n1 RUNS\n2 ENDS\n", "top.inner.kind[1:0]": "0 NEAR\n2 FAR\n"}
