"""The command line: ``python -m hw COMMAND``."""

from pathlib import Path

import click

from golden.commands.command_line import CommandLine
from golden.commands.parameters import ASSIGNMENTS, FILE, PRESET
from golden.config import PRESETS
from golden.errors import InputError
from hw.package.core_files import write_core
from hw.package.tops import TOPS
from hw.registers.page import page
from hw.report import UNITS, measure, table
from hw.synthesis.flow import tool_versions

__all__ = ["main"]


@click.group(cls=CommandLine, no_args_is_help=False,
             context_settings={"max_content_width": 110, "show_default": True})
@click.version_option(package_name="radiosity-engine", prog_name="hw")
def main():
    """Radiosity Engine, hardware: its Verilog, area and clock of its blocks, and its registers."""


@main.command()
@click.argument("block", type=click.Choice(list(UNITS)))
@click.option("--unit", "units", multiple=True, metavar="UNIT", help="Only this one. May be repeated.  [default: all]")
@click.option("--route/--no-route", default=True, help="Place and route for the clock, or only count the area.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Of the placer.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/report"), help="Folder for netlists and tables.")
@PRESET
@ASSIGNMENTS
def report(block, units, route, seed, folder, preset, assignments):
    """Area and clock of a block and of its units alone, on an ECP5-85 with open tools.

    Prints a table and writes it to FOLDER/BLOCK.md, with the logs of the tools beside it.
    """
    config = PRESETS[preset].with_parameters(assignments)
    tool_versions()
    for unit in units:
        if unit not in UNITS[block]:
            raise InputError(f"report: Unit must be one of {', '.join(UNITS[block])}, not {unit!r}")
    rows = []
    for unit in units or UNITS[block]:
        click.echo(f"{unit} ...", err=True)
        rows.append(measure(block, unit, config, folder / block, seed=seed, route=route))
    text = table(rows, block=block, preset=preset, config=config, seed=seed)
    (folder / f"{block}.md").write_text(text)
    click.echo(text, nl=False)


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
@click.option("-o", "--output", "path", type=FILE, help="Where to.  [default: print it]")
def registers(path):
    """The page on the registers."""
    if path is None:
        click.echo(page(), nl=False)
    else:
        path.write_text(page())
