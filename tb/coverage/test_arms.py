"""Arms are reported when they are entered, and only then."""

from pathlib import Path

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hw.export import verilog_of
from tb.coverage.arms import MARK, reported
from tb.coverage.table import missing, table

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
    """What is elaborated, and what is entered while the component counts for some cycles."""
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
        return known, {line.removeprefix(MARK) for line in said}

    return run


def test_all_arms_are_known(simulated):
    assert lines(simulated(1)[0]) == names("up", "down", "high", "idle", "leaves", "busy", "never")


def test_arms_are_reported_when_they_are_entered(simulated):
    assert lines(simulated(1)[1]) == names("up", "idle", "leaves")
    assert lines(simulated(5)[1]) == names("up", "high", "idle", "leaves", "busy")
    assert lines(simulated(5, down=1)[1]) == names("down", "idle", "leaves", "busy")


def test_exported_verilog_reports_too():
    with reported(HERE) as known:
        text = verilog_of(Counts(), "top")
    assert all(f'$write("{MARK}{arm}\\n")' in text for arm in known)
    assert MARK not in verilog_of(Counts(), "top")


def test_files_elsewhere_are_not_reported():
    with reported(HERE / "nothing") as known:
        assert MARK not in verilog_of(Counts(), "top")
    assert not known


def test_the_table_counts_arms_by_folder():
    elaborated = ["hw/a/x.py:1:1", "hw/a/x.py:12:1", "hw/a/x.py:2:1", "hw/b/y.py:1:1"]
    entered, excluded = ["hw/a/x.py:1:1"], ["hw/a/x.py:2:1", "hw/a/x.py:1:1"]
    assert table(elaborated, entered, excluded).splitlines()[2:] == [
        "| `hw/a` | 3 | 1 | 1 | 50.0 |", "| `hw/b` | 1 | 0 | 0 | 0.0 |", "| all | 4 | 1 | 1 | 33.3 |"]
    assert missing(elaborated, entered, excluded) == ["hw/a/x.py:12:1", "hw/b/y.py:1:1"]
    assert missing(reversed(elaborated), [], []) == ["hw/a/x.py:1:1", "hw/a/x.py:2:1", "hw/a/x.py:12:1",
                                                     "hw/b/y.py:1:1"]
