"""``registers``: the page on the registers."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.parameters import FILE

__all__ = ["registers"]


@click.command("registers", cls=Task, extra="sim", short_help="Write the page on the registers.")
@click.option("-o", "--output", "path", type=FILE, help="Write to this file.  [default: print the page]")
def registers(path):
    """Write the page on the registers, in Markdown."""
    from radiosity.flow.output import write_text
    from radiosity.flow.package.registers_page import page

    text = page()
    if path is None:
        console().report({"page": text}, text.rstrip("\n"))
        return
    write_text(path, text)
    console().report({"output": path}, str(path))
