"""``report``: area and clock of a block's units."""

from dataclasses import asdict
from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.hw.choices import BLOCKS, FAMILIES, MHZ, NEXTPNR
from radiosity.cli.hw.nextpnr_options import NEXTPNR_OPTIONS
from radiosity.cli.parameters import ASSIGNMENTS, FILE, PRESET, is_given

__all__ = ["report"]

_OF_ROUTES = {"seeds": "--seed", "nextpnr": "--nextpnr", "routability_driven": "--routability-driven"}


@click.command("report", cls=Task, extra="synth", named={"unit": "--unit"},
               short_help="Measure area and clock of a block's units.")
@click.argument("block", type=click.Choice(BLOCKS))
@click.option("--unit", "units", multiple=True, metavar="UNIT",
              help="Measure only this unit. May be repeated.  [default: all]")
@click.option("--family", type=click.Choice(FAMILIES), default="ecp5",
              help="Choose the FPGA family. Only the ECP5 has a clock.")
@click.option("--liberty", type=FILE, metavar="FILE", help="Map to the standard cells of this Liberty file instead of "
              "an FPGA: area and the delay of the logic before layout.")
@click.option("--route/--no-route", default=None, help="Place and route for the clock, or only count the area.  "
              "[default: route where there is a clock]")
@click.option("--seed", "seeds", type=click.IntRange(0), multiple=True, default=(1,),
              help="Set the placer's seed. May be repeated: the least, median and best clock are reported.")
@click.option("--nextpnr", type=NEXTPNR_OPTIONS, default=NEXTPNR, help="Replace the options of nextpnr. For the "
              "largest units its other router terminates sooner: '--router router2'. Unless --freq is among them the "
              f"target is {MHZ} MHz.")
@click.option("--routability-driven", is_flag=True, help="Let timing decide the placement only. On a nearly full chip "
              "the router terminates sooner so, and may find no other route.")
@click.option("--record", "records", is_flag=True, help="Write the figures to the history, docs/figures/history.csv.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/report"),
              help="Write netlists and tables to this folder.")
@PRESET
@ASSIGNMENTS
def report(block, units, family, liberty, route, seeds, nextpnr, routability_driven, records, folder, preset,
           assignments):
    """Measure area and clock of each unit of BLOCK alone, with open tools.

    The clocks are of an ECP5-85 of speed grades 6 and 8; other families have the area only. Prints a table and writes
    it to FOLDER/BLOCK.md, with the tools' logs beside it. With --liberty it is of an ASIC, and FOLDER/BLOCK-cells.md
    has area and delay.
    """
    from golden.base.errors import InputError
    from golden.base.progress_bar import progress_bar
    from golden.engine.config import PRESETS
    from radiosity.flow.output import write_text
    from radiosity.flow.synthesis.family import FAMILIES as KNOWN
    from radiosity.flow.synthesis.flow import check_options, tool_versions
    from radiosity.flow.synthesis.history import Record, add_record, measured_commit
    from radiosity.flow.synthesis.report import UNITS, measure, table

    config = PRESETS[preset].with_parameters(assignments)
    for unit in units:
        if unit not in UNITS[block]:
            raise InputError(f"report: Unit must be one of {', '.join(UNITS[block])}, not {unit!r}", parameter="unit")
    units = units or tuple(UNITS[block])
    if liberty:
        for name, option in {"family": "--family", "route": "--route", **_OF_ROUTES, "records": "--record"}.items():
            if is_given(name):
                raise InputError(f"report: --liberty goes without {option}, which is of FPGAs")
        _report_cells(block, units, liberty, folder, preset, config)
        return
    tools = tool_versions(clock=KNOWN[family].has_clock)
    if route and not KNOWN[family].has_clock:
        raise InputError(f"report: there is no place and route for {KNOWN[family].title}")
    routes = KNOWN[family].has_clock and route is not False
    for name, option in _OF_ROUTES.items():
        if not routes and is_given(name):
            raise InputError(f"report: {option} needs place and route")
    seeds, options = (tuple(dict.fromkeys(seeds)), nextpnr) if routes else ((), ())
    if routes:
        check_options(options)
    place = {"family": family, "seeds": seeds, "options": options, "routability_driven": routability_driven}
    routing = ("routability-driven" if routability_driven else "timing-driven") if routes else ""
    measured = measured_commit() if records else None
    name = block if family == "ecp5" else f"{block}-{family}"
    rows = []
    with progress_bar(units, desc=block, unit="unit", disable=not console().progress) as bar:
        for unit in bar:
            bar.set_postfix_str(unit)
            rows.append(measure(block, unit, config, folder / name, **place))
            if records:
                add_record(Record.of(rows[-1], measured, tools=tools, family=family, preset=preset,
                                     parameters=" ".join(assignments), block=block, options=" ".join(options),
                                     routing=routing))
    text = table(rows, block=block, preset=preset, config=config, **place)
    write_text(folder / f"{name}.md", text)
    console().report({"output": folder / f"{name}.md", "block": block, "preset": preset, "tools": tools, **place,
                      "parameters": config.parameters(), "units": [asdict(row) for row in rows]}, text.rstrip("\n"))


def _report_cells(block, units, liberty, folder, preset, config):
    """Area and delay in the cells of a Liberty file."""
    from golden.base.progress_bar import progress_bar
    from radiosity.flow.output import write_text
    from radiosity.flow.synthesis.cell_report import cell_table, measure_cells
    from radiosity.flow.synthesis.flow import tool_versions

    name, tools, rows = f"{block}-cells", tool_versions(clock=False), []
    with progress_bar(units, desc=block, unit="unit", disable=not console().progress) as bar:
        for unit in bar:
            bar.set_postfix_str(unit)
            rows.append(measure_cells(block, unit, config, liberty, folder / name))
    text = cell_table(rows, block=block, preset=preset, config=config, liberty=liberty, tools=tools)
    write_text(folder / f"{name}.md", text)
    console().report({"output": folder / f"{name}.md", "block": block, "liberty": liberty,
                      "parameters": config.parameters(), "units": [asdict(row) for row in rows]}, text.rstrip("\n"))
