"""``pictures``: the documentation's pictures."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.parameters import FILE

__all__ = ["pictures"]


@click.command("pictures", cls=Task, extra="sim", short_help="Render the documentation's pictures.")
@click.argument("folder", type=FILE, default=Path("docs/pictures"))
def pictures(folder):
    """Render one picture for each built-in scene, and one by the simulated machine, into FOLDER.

    FOLDER is docs/pictures unless given.
    """
    from radiosity.cli.check_simulator import check_simulator
    from radiosity.cli.documentation_pictures import write_pictures

    check_simulator()
    paths = write_pictures(folder)
    console().report({"output": paths}, f"\n{len(paths)} pictures in {folder}")
