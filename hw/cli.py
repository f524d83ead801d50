"""The command line: ``python -m hw COMMAND``."""

import shlex
from pathlib import Path

import click

from golden.commands.command_line import CommandLine
from golden.commands.parameters import ASSIGNMENTS, FILE, PRESET, Positive, WholePair
from golden.config import PRESETS
from golden.errors import InputError
from hw.board.board_shell import BoardShell
from hw.board.record import record
from hw.board.view import BOARD, board_view
from hw.figures import write_tables
from hw.history import Record, add_record, measured_commit
from hw.output import write_text
from hw.package.core_files import write_core
from hw.package.tops import TOPS
from hw.registers.page import page
from hw.report import UNITS, measure, table
from hw.synthesis.family import FAMILIES
from hw.synthesis.flow import MHZ, OPTIONS, tool_versions

__all__ = ["main"]


@click.group(cls=CommandLine, no_args_is_help=False,
             context_settings={"max_content_width": 110, "show_default": True})
@click.version_option(package_name="radiosity-engine", prog_name="hw")
def main():
    """Radiosity Engine, hardware: its Verilog, area and clock of its blocks, and its registers."""


@main.command()
@click.argument("block", type=click.Choice(list(UNITS)))
@click.option("--unit", "units", multiple=True, metavar="UNIT", help="Only this one. May be repeated.  [default: all]")
@click.option("--family", type=click.Choice(list(FAMILIES)), default="ecp5", help="Of FPGAs. Only the ECP5 has a "
              "clock.")
@click.option("--route/--no-route", default=None, help="Place and route for the clock, or only count the area.  "
              "[default: route where there is a clock]")
@click.option("--seed", "seeds", type=click.IntRange(0), multiple=True, default=(1,), help="Of the placer. May be "
              "repeated: least, median and best clock.")
@click.option("--nextpnr", default=" ".join(OPTIONS), help="More options of nextpnr. Of the largest units its "
              f"other router comes to an end sooner: '--router router2'. Unless --freq is among them {MHZ} MHz are "
              "asked for.")
@click.option("--record", "records", is_flag=True, help="Write the figures into the history, docs/figures/history.csv.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/report"), help="Folder for netlists and tables.")
@PRESET
@ASSIGNMENTS
def report(block, units, family, route, seeds, nextpnr, records, folder, preset, assignments):
    """Area and clock of a block's units alone, on an ECP5-85 or, area only, in other families, with open tools.

    Prints a table and writes it to FOLDER/BLOCK.md, with the logs of the tools beside it.
    """
    config = PRESETS[preset].with_parameters(assignments)
    tools = tool_versions(FAMILIES[family])
    for unit in units:
        if unit not in UNITS[block]:
            raise InputError(f"report: Unit must be one of {', '.join(UNITS[block])}, not {unit!r}")
    if route and not FAMILIES[family].has_clock:
        raise InputError(f"report: nothing here places and routes for {FAMILIES[family].title}")
    seeds = tuple(dict.fromkeys(seeds)) if FAMILIES[family].has_clock and route is not False else ()
    options = tuple(shlex.split(nextpnr)) if seeds else ()
    measured = measured_commit() if records else None
    name = block if family == "ecp5" else f"{block}-{family}"
    rows = []
    for unit in units or UNITS[block]:
        click.echo(f"{unit} ...", err=True)
        rows.append(measure(block, unit, config, folder / name, family=family, seeds=seeds, options=options))
        if records:
            add_record(Record.of(rows[-1], measured, tools=tools, family=family, preset=preset,
                                 parameters=" ".join(assignments), block=block, options=" ".join(options)))
    text = table(rows, block=block, preset=preset, config=config, family=family, seeds=seeds, options=options)
    write_text(folder / f"{name}.md", text)
    click.echo(text, nl=False)


@main.command()
def figures():
    """The tables of area and clock in README.md and docs/, from the history."""
    for path in write_tables():
        click.echo(path)


@main.command()
@click.option("--top", type=click.Choice(list(TOPS)), default="engine", help="What of it.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/verilog"), help="Folder for the files.")
@PRESET
@ASSIGNMENTS
def verilog(top, folder, preset, assignments):
    """Verilog for synthesis and simulation, with constraints, a description for FuseSoC, and a side-car of facts."""
    for path in write_core(top, config=PRESETS[preset].with_parameters(assignments), preset=preset, folder=folder):
        click.echo(path)


@main.command()
@click.option("--scene", default="cornell", help="A built-in scene; the board casts the view into it.")
@click.option("--pixels", type=WholePair("WIDTHxHEIGHT"), default="64x64", help="Rays of the view.")
@click.option("--cell", type=Positive(), default=0.25, help="Cell size as a share of the scene's longest side.")
@click.option("--baud", type=click.IntRange(300, 3_000_000), default=115_200, help="Of the serial line.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Of the placer.")
@click.option("--nextpnr", help="More options of nextpnr.  [default: for little room and a slow clock]")
@click.option("--no-bitstream", is_flag=True, help="Only write Verilog and constraints.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/board"), help="Folder for the files.")
@ASSIGNMENTS
def board(scene, pixels, cell, baud, seed, nextpnr, no_bitstream, folder, assignments):
    """A bitstream for the ULX3S with an ECP5-85: casts a frustum and sends the hits.

    One cluster with little of everything, see `docs/board.md`.
    """
    try:
        from hw.board.ulx3s import CLOCK_HZ, NEXTPNR, build
    except ModuleNotFoundError as error:
        raise InputError(f"board: {error.name} is not installed; `make setup` installs it") from None
    if not no_bitstream:
        tool_versions()
    config = BOARD.with_parameters(assignments)
    program = record(board_view(config, scene=scene, pixels=pixels, cell=cell).image, config)
    shell = BoardShell(config=config, program=program, divisor=round(CLOCK_HZ / baud))
    options = NEXTPNR if nextpnr is None else tuple(shlex.split(nextpnr))
    for path in build(shell, folder, seed=seed, routes=not no_bitstream, options=options):
        click.echo(path)


@main.command()
@click.option("-o", "--output", "path", type=FILE, help="Where to.  [default: print it]")
def registers(path):
    """The page on the registers."""
    if path is None:
        click.echo(page(), nl=False)
    else:
        write_text(path, page())
