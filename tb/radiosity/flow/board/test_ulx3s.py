"""The board's files, of a shell with next to nothing in it; the command."""

import json
import re
from functools import partial
from types import SimpleNamespace

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from click.testing import CliRunner

import radiosity.cli.hw.main
from radiosity.flow.board.ulx3s import CLOCK_HZ, NEXTPNR, build
from radiosity.flow.synthesis.family import Area
from radiosity.flow.synthesis.flow import Bitstream, Clock
from radiosity.flow.synthesis.history import Commit, add_record, last_records, read_history


class Counter(wiring.Component):
    """The pins of a shell."""

    def __init__(self):
        super().__init__({"tx": Out(1, init=1), "again": In(1), "busy": Out(1), "failed": Out(1)})

    def elaborate(self, platform):
        m = Module()
        count = Signal(20)
        m.d.sync += count.eq(count + 1 + self.again)
        m.d.comb += [self.tx.eq(count[3]), self.busy.eq(count[-1]), self.failed.eq(count[-1] & self.again)]
        return m


def test_constraints_are_of_the_verilogs_ports(tmp_path):
    (verilog, constraints), _ = build(Counter(), tmp_path / "board", seeds=())
    ports = set(re.search(r"module top\((.*?)\)", verilog.read_text())[1].split(", "))
    text = constraints.read_text()
    # Of the board's schematics.
    assert dict(re.findall(r'LOCATE COMP "(\w+)" SITE "(\w+)"', text)) == {
        "uart_0__tx__io": "L4", "led_0__io": "B2", "led_1__io": "C2", "button_fire_0__io": "R1", "clk25_0__io": "G2"}
    assert ports == set(re.findall(r'COMP "(\w+)"', text)), "names of ports"
    (clock,) = re.findall(r'FREQUENCY PORT "clk25_0__io" ([\d.]+) HZ', text)
    assert float(clock) == CLOCK_HZ


@pytest.fixture
def tools(monkeypatch):
    """The calls of synthesis, place and route, in place of which there are figures, and no Verilog."""
    found = []

    def bitstream(*_, **given):
        found.append(given)
        return Bitstream(area=Area(lut=1, ff=2, dsp=3, bram=4), synthesis_seconds=7, route_seconds=(8, 9),
                         clocks=(Clock(seed=5, mhz=60.04, path="a path"), Clock(seed=6, mhz=50.0, path="a path")))

    files = dict.fromkeys(("top.lpf", "top.debug.v", "top.il"), "")
    monkeypatch.setattr("radiosity.flow.board.ulx3s.ULX3S_85F_Platform.prepare", lambda *_,
                        **__: SimpleNamespace(files=files))
    monkeypatch.setattr("radiosity.flow.synthesis.flow.tool_versions", lambda: "tools")
    monkeypatch.setattr("radiosity.flow.synthesis.flow.check_options", lambda *_, **__: None)
    monkeypatch.setattr("radiosity.flow.board.ulx3s.bitstream", bitstream)
    return found


@pytest.mark.parametrize(("more", "options"), [
    ([], NEXTPNR), (["--nextpnr", ""], ()), (["--nextpnr", "--placer 'static'"], ("--placer", "static"))])
def test_options_replace_the_default(more, options, tools, tmp_path):
    result = CliRunner().invoke(radiosity.cli.hw.main.main, ["board", "-o", str(tmp_path), "--seed", "5", "--seed", "6",
                                                             *more])
    assert result.exit_code == 0, result.output
    assert tools == [{"seeds": (5, 6), "options": options}]
    assert result.output.splitlines()[0] == (
        "1 LUT, 2 registers, 3 DSP blocks, 4 block RAM; 50.0 / 55.0 / 60.0 MHz of 25; processor time: synthesis 7 s, "
        "place and route 8, 9 s")


def test_figures_of_the_machine_are_recorded(tools, monkeypatch, tmp_path):
    """As `radiosity bench throughput` and the pages look for them."""
    path = tmp_path / "history.csv"
    monkeypatch.setattr("radiosity.flow.synthesis.history.measured_commit", lambda: Commit(name="a", date="2026-11-29"))
    monkeypatch.setattr("radiosity.flow.synthesis.history.add_record", partial(add_record, path=path))
    result = CliRunner().invoke(radiosity.cli.hw.main.main, ["board", "-o", str(tmp_path), "--record"])
    assert result.exit_code == 0, result.output
    record, = last_records(read_history(path)).values()
    assert record.key == ("ecp5", "board", "", "board", "BoardShell")
    assert (record.lut, record.seeds, record.mhz, record.mhz_grade_8) == (1, (5, 6), (60.0, 50.0), ())
    assert (record.options, record.routing) == (" ".join(NEXTPNR), "wirelength-driven")


@pytest.mark.nightly
def test_bitstream(tmp_path):
    (*_, stream, figures), _ = build(Counter(), tmp_path, seeds=(1,))
    # What an ECP5-85 begins with, and says that it is.
    assert b"LFE5U-85F" in stream.read_bytes()[:200]
    found = json.loads(figures.read_text())
    assert found["area"]["ff"] >= 20
    assert found["clocks"][0]["mhz"] > CLOCK_HZ / 1e6


@pytest.mark.parametrize(("arguments", "message"), [
    (["-P", "noc.columns=4"], "a power of two"), (["--pixels", "96x64"], "at most 64 (icu.side_bits), not 96"),
    (["--scene", "nowhere"], "nowhere"), (["--record"], "which --no-bitstream leaves out"),
    (["--baud", "100"], "100 is not in the range")])
def test_what_cannot_be_built_is_refused(tmp_path, capsys, arguments, message):
    with pytest.raises(SystemExit) as raised:
        radiosity.cli.hw.main.main(["board", "--no-bitstream", "-o", str(tmp_path / "board"), *arguments])
    assert raised.value.code == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "board").exists()
