"""The command line: ``radiosity COMMAND``."""

from radiosity.cli.bench import bench
from radiosity.cli.command_line import command_line
from radiosity.cli.demo import demo
from radiosity.cli.golden.cast import cast_command
from radiosity.cli.golden.config import show_config
from radiosity.cli.golden.exchange import exchange_command
from radiosity.cli.golden.formfactors import formfactors_command
from radiosity.cli.golden.image import image_command
from radiosity.cli.golden.intersect import intersect
from radiosity.cli.golden.render import render_command
from radiosity.cli.golden.scenes import export, list_scenes
from radiosity.cli.golden.schedule import schedule_command
from radiosity.cli.golden.stimulus import export_stimulus
from radiosity.cli.hw.board import board
from radiosity.cli.hw.figures import figures
from radiosity.cli.hw.registers import registers
from radiosity.cli.hw.report import report
from radiosity.cli.hw.soc import soc
from radiosity.cli.hw.verilog import verilog
from radiosity.cli.machine import machine
from radiosity.cli.machine_method import MachineMethod
from radiosity.cli.pictures import pictures

__all__ = ["MACHINE", "main"]

MACHINE = MachineMethod()


@command_line("radiosity")
def main():
    """Radiosity Engine: render scenes, cast on the simulated machine, and generate its hardware."""


for _command in (render_command(MACHINE), formfactors_command(MACHINE), exchange_command, cast_command(MACHINE),
                 schedule_command, image_command, intersect, list_scenes, export, show_config, export_stimulus, verilog,
                 report, figures, registers, board, soc, bench, machine, demo, pictures):
    main.add_command(_command)
