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
@click.option("--seed", "seeds", type=click.IntRange(0), multiple=True, default=(1,), help="Set the placer's seed. May "
              "be repeated: the least, median and best clock are reported, and the bitstream is that of the best.")
@click.option("--nextpnr", type=NEXTPNR_OPTIONS, default=BOARD_NEXTPNR, help="Replace the options of nextpnr. The "
              "default is for high utilization and a slow clock.")
@click.option("--no-bitstream", is_flag=True, help="Only write Verilog and constraints.")
@click.option("--record", "records", is_flag=True, help="Write the figures to the history, docs/figures/history.csv.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/board"), help="Write the files to this folder.")
@ASSIGNMENTS
def board(scene, pixels, cell, baud, seeds, nextpnr, no_bitstream, records, folder, assignments):
    """Make a bitstream for the ULX3S with an ECP5-85 that casts a frustum and sends the hits.

    The machine is that of preset board, a cluster and a patch node; with -P noc.patch_nodes=0 it has two clusters,
    which exceed the ECP5-85. See `docs/board.md`.
    """
    from dataclasses import asdict

    from golden.base.errors import InputError
    from golden.base.stage_progress import StageProgress
    from golden.engine.config import PRESETS
    from hw.board.board_shell import BoardShell
    from radiosity.flow.board.record import record
    from radiosity.flow.board.ulx3s import CLOCK_HZ, build
    from radiosity.flow.board.view import board_view
    from radiosity.flow.synthesis.flow import check_options, tool_versions
    from radiosity.flow.synthesis.history import MACHINE, Record, add_record, machine_parameters, measured_commit
    from radiosity.flow.synthesis.report import Row, spread

    if no_bitstream and records:
        raise InputError("board: --record needs a bitstream, which --no-bitstream leaves out")
    if not no_bitstream:
        tools = tool_versions()
        check_options(nextpnr, has_constraints=True)
    measured = measured_commit() if records else None
    seeds = () if no_bitstream else tuple(dict.fromkeys(seeds))
    config = PRESETS["board"].with_parameters(assignments)
    program = record(board_view(config, scene=scene, pixels=pixels, cell=cell).job)
    shell = BoardShell(config=config, program=program, divisor=round(CLOCK_HZ / baud))
    stage = "write Verilog" if no_bitstream else "synthesis, place and route"
    with (StageProgress("board", {stage: 15.0 if no_bitstream else 600.0 + 900.0 * len(seeds)},
                        shown=console().progress) as bar, bar.stage(stage)):
        files, figures = build(shell, folder, seeds=seeds, options=nextpnr)
    paths, facts, lines = [str(path) for path in files], {}, []
    if figures:
        facts, area = asdict(figures), figures.area
        lines = [f"{area.lut} LUT, {area.ff} registers, {area.dsp} DSP blocks, {area.bram} block RAM; "
                 f"{spread((clock.mhz for clock in figures.clocks), digits=1)} MHz of {CLOCK_HZ / 1e6:g}; processor "
                 f"time: synthesis {figures.synthesis_seconds} s, place and route "
                 f"{', '.join(map(str, figures.route_seconds))} s"]
    if records:
        block, unit = MACHINE
        add_record(Record.of(Row(unit=unit, latency=None, area=area, clocks=figures.clocks), measured, tools=tools,
                             family="ecp5", preset="board", block=block,
                             parameters=machine_parameters("board", assignments),
                             options=" ".join(nextpnr), routing="wirelength-driven"))
    console().report({"output": paths, **facts}, "\n".join([*lines, *paths]))
