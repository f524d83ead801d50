"""``soc``: a bitstream of an engine with SDRAM."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.hw.choices import SOC_NEXTPNR
from radiosity.cli.hw.nextpnr_options import NEXTPNR_OPTIONS
from radiosity.cli.parameters import ASSIGNMENTS, FILE, FiniteRange

__all__ = ["soc"]

# Seconds that the stages take.
_SECONDS = {"export": 20.0, "LiteX": 3.0, "synthesis, place and route": 3000.0}


@click.command("soc", cls=Task, extra="synth", short_help="Make a bitstream with SDRAM for the ULX3S.")
@click.option("--mhz", type=FiniteRange(10, 100), default=25.0, help="Set the clock, which the bitstream must "
              "reach.")
@click.option("--baud", type=click.IntRange(300, 3_000_000), default=1_000_000, help="Set the rate of the serial line.")
@click.option("--revision", type=click.Choice(("1.7", "2.0")), default="2.0", help="Name the board's revision, 2.0 for "
              "later ones too.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Set the placer's seed.")
@click.option("--nextpnr", type=NEXTPNR_OPTIONS, default=SOC_NEXTPNR, help="Replace the options of nextpnr. The "
              "default is for high utilization; --mhz is the target.")
@click.option("--litex", type=FILE, default=Path("build/litex/bin/python"), help="Name the Python that has LiteX; "
              "`make litex` installs the default.")
@click.option("--no-bitstream", is_flag=True, help="Only write the engine, Verilog and constraints.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/soc"), help="Write the files to this folder.")
@ASSIGNMENTS
def soc(mhz, baud, revision, seed, nextpnr, litex, no_bitstream, folder, assignments):
    """Make a bitstream for the ULX3S with an ECP5-85: an engine in a SoC of LiteX, with the board's SDRAM.

    A host at the USB socket loads jobs of `radiosity image` and casts them, see `docs/board.md`.
    """
    from golden.base.stage_progress import StageProgress
    from radiosity.flow.board.soc import SOC, build_soc
    from radiosity.flow.synthesis.flow import tool_versions

    if not no_bitstream:
        tool_versions()
    stages = dict(list(_SECONDS.items())[:2] if no_bitstream else _SECONDS)
    with StageProgress("SoC", stages, shown=console().progress) as bar:
        facts = build_soc(SOC.with_parameters(assignments), folder, litex=litex.absolute(), hertz=round(mhz * 1e6),
                          baud=baud, revision=revision, seed=seed, options=nextpnr, stage=bar.stage,
                          routes=not no_bitstream)
    lines = [] if no_bitstream else [
        f"{facts['lut']} LUT, {facts['ff']} registers, {facts['dsp']} DSP blocks, {facts['bram']} block RAM; "
        f"{facts['mhz']:.1f} MHz of {mhz:g}; {facts['seconds']} s"]
    console().report(facts, "\n".join([*lines, *facts["output"]]))
