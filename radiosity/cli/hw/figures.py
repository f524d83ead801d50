"""``figures``: the tables of area and clock in the documentation."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console

__all__ = ["figures"]


@click.command("figures", cls=Task, extra="synth", short_help="Write the documentation's tables of area and clock.")
def figures():
    """Write the tables of area and clock in README.md and docs/ from the history."""
    from radiosity.flow.synthesis.figures import write_tables

    paths = [str(path) for path in write_tables()]
    console().report({"output": paths}, "\n".join(paths))
