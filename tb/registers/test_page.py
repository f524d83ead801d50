from pathlib import Path

from click.testing import CliRunner

from hw.registers.engine_registers import ADDRESS_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import ABOUT, CODE_BITS, ErrorCode
from hw.registers.register import WORD_BYTES, addresses
from radiosity.cli.hw.main import main
from radiosity.flow.package.registers_page import page

PAGE = Path(__file__).parents[2] / "docs" / "formats" / "registers.md"


def test_the_page_is_what_the_command_writes(tmp_path):
    assert PAGE.read_text() == page(), "python -m hw registers -o docs/formats/registers.md"
    result = CliRunner().invoke(main, ["registers", "-o", str(tmp_path / "page.md")])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "page.md").read_text() == page()
    assert CliRunner().invoke(main, ["registers"]).output == page()


def test_every_error_has_a_meaning():
    assert ABOUT.keys() == {one.name for one in ErrorCode}
    assert max(one.value for one in ErrorCode) < 1 << CODE_BITS


def test_registers_lie_below_the_counters():
    offsets = addresses(ENGINE_REGISTERS)
    last = ENGINE_REGISTERS[-1]
    assert offsets[last.name] + WORD_BYTES * last.words <= COUNTERS_BASE == 1 << ADDRESS_BITS - 1
