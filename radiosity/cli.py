"""The command line: ``radiosity COMMAND``."""

from golden.commands.cast import cast_command
from golden.commands.command_line import command_line
from golden.commands.config import show_config
from golden.commands.exchange import exchange_command
from golden.commands.formfactors import formfactors_command
from golden.commands.image import image_command
from golden.commands.intersect import intersect
from golden.commands.render import render_command
from golden.commands.scenes import export, list_scenes
from golden.commands.schedule import schedule_command
from golden.commands.stimulus import export_stimulus
from hw.commands.board import board
from hw.commands.figures import figures
from hw.commands.registers import registers
from hw.commands.report import report
from hw.commands.soc import soc
from hw.commands.verilog import verilog
from radiosity.commands.bench import bench
from radiosity.commands.demo import demo
from radiosity.commands.machine import machine
from radiosity.commands.pictures import pictures
from radiosity.machine_method import MachineMethod

__all__ = ["METHODS", "main"]

# Ways to cast frusta beside those of golden.
METHODS = (MachineMethod(),)


@command_line("radiosity")
def main():
    """Radiosity Engine: render scenes, cast on the simulated machine, and generate its hardware."""


for _command in (render_command(*METHODS), formfactors_command(*METHODS), exchange_command, cast_command(*METHODS),
                 schedule_command, image_command, intersect, list_scenes, export, show_config, export_stimulus, verilog,
                 report, figures, registers, board, soc, bench, machine, demo, pictures):
    main.add_command(_command)
