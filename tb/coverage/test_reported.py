"""Arms and toggles are reported when they are covered, and only then."""

from pathlib import Path

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from radiosity.flow.verilog.export import verilog_of
from tb.coverage import toggles
from tb.coverage.arms import MARK
from tb.coverage.reported import reported
from tb.coverage.table import missing, needless, table

HERE = Path(__file__).parent
LINES = Path(__file__).read_text().splitlines()


class Counts(wiring.Component):
    """Counts while requested, up and down."""

    go: In(1)
    down: In(1)
    o: Out(4)
    high: Out(1)
    waited: Out(1)
    busy: Out(1)

    def elaborate(self, platform):
        m = Module()
        twice = Signal(2)
        m.d.sync += twice.eq(twice + 2)
        with m.If(self.go & ~self.down):  # up
            m.d.sync += self.o.eq(self.o + 1)
        with m.Elif(self.go):  # down
            m.d.sync += self.o.eq(self.o - 1)
        with m.If(self.o == 2):  # high
            m.d.comb += self.high.eq(1)
        with m.FSM():
            with m.State("IDLE"):  # idle
                m.d.sync += self.waited.eq(1)
                with m.If(self.go):  # leaves
                    m.next = "BUSY"
            with m.State("BUSY"):  # busy
                m.d.comb += self.busy.eq(1)
                with m.If(self.o == 9):  # never
                    m.next = "IDLE"
        return m


def names(*words):
    """The lines of arms, found by their comments."""
    return {next(number for number, line in enumerate(LINES, 1) if line.endswith(f"# {word}")) for word in words}


def lines(arms):
    return {int(arm.split(":")[1]) for arm in arms}


@pytest.fixture
def simulated(capsys):
    """What is elaborated, and what is covered while the component counts for some cycles: arms, and toggles."""
    def run(cycles, down=0):
        with reported(HERE) as known:
            component = Counts()
            simulator = Simulator(component)
            simulator.add_clock(1e-6)

            async def stimulus(ctx):
                ctx.set(component.go, 1)
                ctx.set(component.down, down)
                await ctx.tick().repeat(cycles)

            simulator.add_testbench(stimulus)
            simulator.run()
        said = capsys.readouterr().out.splitlines()
        assert len(said) == len(set(said))
        arms = {line.removeprefix(MARK) for line in said if line.startswith(MARK)}
        bits = [toggles.toggles(line.removeprefix(toggles.MARK)) for line in said if line.startswith(toggles.MARK)]
        return known, (arms, set().union(*bits))

    return run


def test_all_arms_are_known(simulated):
    assert lines(simulated(1)[0][0]) == names("up", "down", "high", "idle", "leaves", "busy", "never")


def test_arms_are_reported_when_they_are_entered(simulated):
    assert lines(simulated(1)[1][0]) == names("up", "idle", "leaves")
    assert lines(simulated(5)[1][0]) == names("up", "high", "idle", "leaves", "busy")
    assert lines(simulated(5, down=1)[1][0]) == names("down", "idle", "leaves", "busy")


def test_all_bits_of_ports_and_registers_are_known_in_both_directions(simulated):
    ports = {"go": 1, "down": 1, "o": 4, "high": 1, "waited": 1, "busy": 1}
    known = simulated(1)[0][1]
    registers = {point for point in known if point.split(":")[1].isdigit()}
    assert known - registers == {
        f"{HERE.name}/{Path(__file__).name}:{name}[{k}]{sign}"
        for name, width in ports.items() for k in range(width) for sign in "+-"}
    line, = lines(registers)
    assert "twice = Signal(2)" in LINES[line - 1]
    assert {point.partition("twice")[2] for point in registers} == {"[0]+", "[0]-", "[1]+", "[1]-"}


def test_bits_are_reported_when_they_toggle(simulated):
    def of(name, run):
        return {point.partition("[")[2] for point in run[1][1] if f":{name}[" in point}

    # It counts 0, 1, 2, ... from the first edge on; a toggle is seen at the edge behind it.
    assert of("o", simulated(2)) == {"0]+"}
    assert of("o", simulated(3)) == {"0]+", "0]-", "1]+"}
    assert of("o", simulated(6)) == {"0]+", "0]-", "1]+", "1]-", "2]+"}
    # 0, 15, 14.
    assert of("o", simulated(3, down=1)) == {"0]+", "1]+", "2]+", "3]+", "0]-"}
    assert of("down", simulated(9)) == set()
    assert of("waited", simulated(9)) == {"0]+"}
    assert of("twice", simulated(9)) == {"1]+", "1]-"}


def test_exported_verilog_reports_too():
    with reported(HERE) as (arms, bits):
        text = verilog_of(Counts(), "top")
    assert all(f'$write("{MARK}{arm}\\n")' in text for arm in arms)
    assert all(f'$write("{toggles.MARK}{bit.rpartition("[")[0]} %0h %0h\\n"' in text for bit in bits)
    assert MARK not in verilog_of(Counts(), "top")


def test_files_elsewhere_are_not_reported():
    with reported(HERE / "nothing") as (arms, bits):
        text = verilog_of(Counts(), "top")
    assert MARK not in text
    assert toggles.MARK not in text
    assert not arms
    assert not bits


RUN = {"arms": {"elaborated": ["hw/a/x.py:1:1", "hw/a/x.py:12:1", "hw/a/x.py:2:1", "hw/b/y.py:1:1"],
                "covered": ["hw/a/x.py:1:1"]},
       "toggles": {"elaborated": [f"hw/a/x.py:o.payload[{k}]{sign}" for k in (0, 1) for sign in "+-"],
                   "covered": ["hw/a/x.py:o.payload[0]+"]}}


def test_the_table_counts_by_folder():
    excluded = ["hw/a/x.py:2:1", "hw/a/x.py:o.payload[1]"]
    assert table(RUN, excluded).splitlines() == [
        "| folder | arms | excluded | covered | toggles | excluded | covered |", "|---|---|---|---|---|---|---|",
        "| `hw/a` | 3 | 1 | 50.0 % | 4 | 2 | 50.0 % |", "| `hw/b` | 1 | 0 | 0.0 % | 0 | 0 | - |",
        "| all | 4 | 1 | 33.3 % | 4 | 2 | 50.0 % |"]
    assert missing(RUN, excluded) == ["hw/a/x.py:12:1", "hw/a/x.py:o.payload 0-", "hw/b/y.py:1:1"]
    assert missing(RUN, ["hw/a/x.py:o.payload"]) == ["hw/a/x.py:2:1", "hw/a/x.py:12:1", "hw/b/y.py:1:1"]
    assert missing(RUN, ()) == ["hw/a/x.py:2:1", "hw/a/x.py:12:1", "hw/a/x.py:o.payload 0- 1+ 1-", "hw/b/y.py:1:1"]


def test_exclusions_that_are_not_needed_are_found():
    assert needless(RUN, ["hw/a/x.py:2:1", "hw/a/x.py:o.payload", "hw/a/x.py:o.payload[1]+"]) == []
    assert needless(RUN, ["hw/a/x.py:1:1", "hw/a/x.py:7:7", "hw/a/x.py:o.payload[0]+"]) == [
        "hw/a/x.py:1:1", "hw/a/x.py:7:7", "hw/a/x.py:o.payload[0]+"]
    # Of another block.
    assert needless(RUN, ["hw/c/z.py:1:1"]) == []
