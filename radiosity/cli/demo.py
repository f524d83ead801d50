"""``demo``: the whole main job, with one page that shows it."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.parameters import FILE

__all__ = ["demo"]


@click.command("demo", cls=Task, extra="sim,plots", short_help="Show the whole main job on one page.")
@click.argument("folder", type=FILE, default=Path("out/demo"))
def demo(folder):
    """Make one page in FOLDER that shows the whole main job, with each command.

    A picture by the golden model, a hemisphere on the simulated hardware with golden's bits, the engine as Verilog, and
    form factors. FOLDER is out/demo unless given. It takes five minutes on two cores, most of them to compile.
    """
    from radiosity.cli.check_simulator import check_simulator
    from radiosity.cli.demo_steps import write_demo

    check_simulator()
    page = write_demo(folder)
    console().report({"output": page}, f"\nthe page is {page}")
