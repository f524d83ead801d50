"""The command line: ``python -m hw COMMAND``."""

from golden.commands.command_line import command_line
from hw.commands.board import board
from hw.commands.figures import figures
from hw.commands.registers import registers
from hw.commands.report import report
from hw.commands.soc import soc
from hw.commands.verilog import verilog

__all__ = ["main"]


@command_line("hw", is_script=False)
def main():
    """Make the hardware: Verilog, area and clock of its blocks, bitstreams, and the page on its registers."""


for _command in (report, figures, verilog, board, soc, registers):
    main.add_command(_command)
