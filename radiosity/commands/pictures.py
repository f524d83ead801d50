"""``pictures``: the documentation's pictures."""

from pathlib import Path

import click

from golden.commands.command_line import Task
from golden.commands.console import console
from golden.commands.parameters import FILE

__all__ = ["pictures"]


@click.command("pictures", cls=Task, extra="sim", short_help="Render the documentation's pictures.")
@click.argument("folder", type=FILE, default=Path("docs/pictures"))
def pictures(folder):
    """Render one picture for each built-in scene, and one by the simulated machine, into FOLDER.

    FOLDER is docs/pictures unless given.
    """
    from radiosity.check_simulator import check_simulator
    from radiosity.pictures import write_pictures

    check_simulator()
    paths = write_pictures(folder)
    console().report({"output": paths}, f"\n{len(paths)} pictures in {folder}")
