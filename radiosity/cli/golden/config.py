"""``config``: the parameters of the machine, what is derived from them, and its parts."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import PRESETS
from radiosity.cli.parameters import ASSIGNMENTS

__all__ = ["show_config"]


@click.command("config", cls=Task, short_help="Print parameters, what is derived from them, and the machine's parts.")
@click.argument("preset", type=click.Choice(PRESETS))
@ASSIGNMENTS
def show_config(preset, assignments):
    """Print the parameters of PRESET, the widths and formats derived from them, and which parts the machine has."""
    from radiosity.tasks.config import config_report

    console().report(*config_report(preset, assignments))
