"""The command line: ``python -m hw COMMAND``."""

from radiosity.cli.command_line import command_line
from radiosity.cli.hw.board import board
from radiosity.cli.hw.figures import figures
from radiosity.cli.hw.registers import registers
from radiosity.cli.hw.report import report
from radiosity.cli.hw.soc import soc
from radiosity.cli.hw.verilog import verilog

__all__ = ["main"]


@command_line("hw", is_script=False)
def main():
    """Make the hardware: Verilog, area and clock of its blocks, bitstreams, and the page on its registers."""


for _command in (report, figures, verilog, board, soc, registers):
    main.add_command(_command)
