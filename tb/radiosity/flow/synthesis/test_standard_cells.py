"""Standard cells: area, registers, macros and delay of logic that can be counted by hand."""

import json
import shutil
from pathlib import Path

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from click.testing import CliRunner

from golden.base.errors import InputError
from radiosity.cli.hw.main import main
from radiosity.flow.synthesis.standard_cells import map_to_cells

CELLS = Path(__file__).with_name("cells.lib")
# Areas and delays of `CELLS`.
INVERTER, NAND, FLOP = 2, 4, 10
INVERTER_DELAY, NAND_DELAY = 0.1, 0.25


class Chain(wiring.Component):
    """A register behind the AND of three inputs, and memories of so many words."""

    def __init__(self, *, words=()):
        self._words = words
        super().__init__({"a": In(4), "q": Out(1), "at": In(8)} | {
            f"word_{number}": Out(4) for number in range(len(words))})

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.q.eq(self.a[:3].all())
        for number, words in enumerate(self._words):
            m.submodules[f"memory_{number}"] = memory = Memory(shape=4, depth=words, init=[])
            read, write = memory.read_port(), memory.write_port()
            m.d.comb += [write.en.eq(1), write.addr.eq(self.at), write.data.eq(self.a), read.addr.eq(self.at),
                         getattr(self, f"word_{number}").eq(read.data)]
        return m


def test_cells_of_an_and_of_three(tmp_path):
    found = map_to_cells(Chain(), CELLS, tmp_path)
    # The reset is a fourth input of the AND; itself it is inverted.
    assert (found.registers, found.register_area, found.ram_bits) == (1, FLOP, 0)
    inverters = found.cells - 1 - 3
    assert inverters in (3, 4)
    assert found.area == FLOP + 3 * NAND + inverters * INVERTER
    # Two levels of AND, at most with an inverter in front. A load adds less than 1 ps.
    levels = round((found.delay - 2 * (NAND_DELAY + INVERTER_DELAY)) / INVERTER_DELAY)
    assert levels in (0, 1)
    assert 0 <= found.delay - 2 * (NAND_DELAY + INVERTER_DELAY) - levels * INVERTER_DELAY < 0.005


def test_only_large_memories_are_macros(tmp_path):
    found = map_to_cells(Chain(words=(16, 17, 64)), CELLS, tmp_path)
    assert found.ram_bits == (17 + 64) * 4
    assert found.registers >= 16 * 4


def test_a_delay_that_is_not_stated_is_an_error(tmp_path, monkeypatch):
    """Logic without a delay would count as infinitely fast."""
    monkeypatch.setattr("radiosity.flow.synthesis.standard_cells._ABC", "strash;dch,-f;map,-B,0.9;topo")
    with pytest.raises(InputError, match="report: ABC has stated no delay, see "):
        map_to_cells(Chain(), CELLS, tmp_path)


def test_a_file_that_is_no_library_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"no Liberty file .*absent\.lib"):
        map_to_cells(Chain(), tmp_path / "absent.lib", tmp_path)
    (tmp_path / "cut.lib").write_text(CELLS.read_text()[:900])
    with pytest.raises(InputError, match=r"report: .* failed, see .*cells\.yosys\.log: "):
        map_to_cells(Chain(), tmp_path / "cut.lib", tmp_path)


def test_the_command_writes_the_table(tmp_path):
    library = tmp_path / "with blank" / "cells.lib"
    library.parent.mkdir()
    shutil.copy(CELLS, library)
    command = ["report", "ctu", "--unit", "CellNumber", "--preset", "tiny", "--liberty", str(library)]
    result = CliRunner().invoke(main, [*command, "-o", str(tmp_path), "--json"])
    assert result.exit_code == 0, result.output
    unit = json.loads(result.output)["units"][0]
    text = (tmp_path / "ctu-cells.md").read_text()
    assert text.startswith("# ctu: cells.lib\n")
    assert f"| CellNumber | 6 | {unit['area']['area']:.0f} | " in text
    assert f" | {unit['area']['delay']:.2f} |\n" in text
    assert "nextpnr" not in text
    assert text.endswith("; preset tiny.\n")


@pytest.mark.parametrize("more", [["--route"], ["--record"], ["--family", "xc7"], ["--seed", "2"],
                                  ["--nextpnr", "--router router2"], ["--routability-driven"]])
def test_what_an_fpga_has_alone_is_refused(more, tmp_path):
    command = ["report", "ctu", "--unit", "CellNumber", "--liberty", str(CELLS), "-o", str(tmp_path), *more]
    result = CliRunner().invoke(main, command)
    assert (result.exit_code, result.output) == (
        2, f"error: report: --liberty goes without {more[0]}, which is of FPGAs\n")
