"""``verilog``: the hardware as Verilog."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.hw.choices import TOPS
from radiosity.cli.parameters import ASSIGNMENTS, FILE, PRESET, FiniteRange

__all__ = ["verilog"]

# Seconds that an export takes with preset paper.
_SECONDS = {"engine": 10.0, "async_engine": 10.0, "cluster": 6.0, "icu": 2.0, "ctu": 3.0, "network": 6.0, "router": 2.0}


@click.command("verilog", cls=Task, extra="sim", short_help="Write Verilog with constraints and a manifest.")
@click.option("--top", type=click.Choice(TOPS), default="engine", help="Choose the top module.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/verilog"), help="Write the files to this "
              "folder.")
@click.option("--period", type=FiniteRange(min=0.1), help="Set the nanoseconds of each clock in the constraints. "
              "Default: one that an ECP5-85 has reached.")
@click.option("--ram-style", "ram_styles", is_flag=True, help="Name the kind of each small or shared memory by the "
              "attribute ram_style, which Vivado knows, and Yosys for some families.")
@PRESET
@ASSIGNMENTS
def verilog(top, folder, period, ram_styles, preset, assignments):
    """Write Verilog for synthesis and simulation, with constraints, a description for FuseSoC, and a manifest."""
    from golden.base.stage_progress import StageProgress
    from golden.engine.config import PRESETS
    from radiosity.flow.package.core_files import write_core

    config = PRESETS[preset].with_parameters(assignments)
    with (StageProgress(f"preset {preset}", {f"export {top}": _SECONDS[top]}, shown=console().progress) as bar,
          bar.stage(f"export {top}")):
        paths = [str(path) for path in write_core(top, config=config, preset=preset, folder=folder,
                                             period=period, ram_styles=ram_styles)]
    console().report({"output": paths}, "\n".join(paths))
