"""``demo``: real scenes, with pictures and a report."""

from pathlib import Path

import click

from golden.commands.command_line import Task
from golden.commands.console import console
from golden.commands.parameters import FILE

__all__ = ["demo"]


@click.command("demo", cls=Task, extra="sim", short_help="Render real scenes, with pictures and a report.")
@click.argument("folder", type=FILE, default=Path("out/demo"))
def demo(folder):
    """Render four scenes, form factors and an image by the simulated machine into FOLDER, with a report.

    FOLDER is out/demo unless given. Without a simulator built before, this takes some ten minutes on two cores.
    """
    from radiosity.check_simulator import check_simulator
    from radiosity.demo import write_demo

    check_simulator()
    report = write_demo(folder)
    console().report({"output": report}, f"\npictures and report in {report}")
