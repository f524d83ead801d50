"""``board``: a bitstream for a board."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.hw.choices import BOARD_NEXTPNR
from radiosity.cli.hw.nextpnr_options import NEXTPNR_OPTIONS
from radiosity.cli.parameters import ASSIGNMENTS, FILE, Positive, WholePair

__all__ = ["board"]


@click.command("board", cls=Task, extra="synth", short_help="Make a bitstream for the ULX3S.")
@click.option("--scene", default="cornell", help="Choose a built-in scene; the board casts its view.")
@click.option("--pixels", type=WholePair("WIDTHxHEIGHT"), default="64x64", help="Set the number of rays of the view.")
@click.option("--cell", type=Positive(), default=0.25, help="Set the cell size as a share of the scene's longest side.")
@click.option("--baud", type=click.IntRange(300, 3_000_000), default=115_200, help="Set the rate of the serial line.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Set the placer's seed.")
@click.option("--nextpnr", type=NEXTPNR_OPTIONS, default=BOARD_NEXTPNR, help="Replace the options of nextpnr. The "
              "default is for high utilization and a slow clock.")
@click.option("--no-bitstream", is_flag=True, help="Only write Verilog and constraints.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/board"), help="Write the files to this folder.")
@ASSIGNMENTS
def board(scene, pixels, cell, baud, seed, nextpnr, no_bitstream, folder, assignments):
    """Make a bitstream for the ULX3S with an ECP5-85 that casts a frustum and sends the hits.

    The machine is one cluster of preset board; with -P noc.columns=2 it has both, which exceed the ECP5-85. See
    `docs/board.md`.
    """
    from golden.base.stage_progress import StageProgress
    from golden.engine.config import PRESETS
    from hw.board.board_shell import BoardShell
    from radiosity.flow.board.record import record
    from radiosity.flow.board.ulx3s import CLOCK_HZ, build
    from radiosity.flow.board.view import board_view
    from radiosity.flow.synthesis.flow import check_options, tool_versions

    if not no_bitstream:
        tool_versions()
        check_options(nextpnr, has_constraints=True)
    config = PRESETS["board"].replace({"noc.columns": 1}).with_parameters(assignments)
    program = record(board_view(config, scene=scene, pixels=pixels, cell=cell).job)
    shell = BoardShell(config=config, program=program, divisor=round(CLOCK_HZ / baud))
    stage = "write Verilog" if no_bitstream else "synthesis, place and route"
    with (StageProgress("board", {stage: 15.0 if no_bitstream else 600.0}, shown=console().progress) as bar,
          bar.stage(stage)):
        paths = [str(path) for path in build(shell, folder, seed=seed, routes=not no_bitstream, options=nextpnr)]
    console().report({"output": paths}, "\n".join(paths))
