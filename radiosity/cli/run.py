"""Commands of this program, run as a user would run them."""

import subprocess
import sys
from pathlib import Path

import click

from radiosity.cli.console import console

__all__ = ["run"]


def run(folder: Path, *arguments: str) -> str:
    """Run ``radiosity`` in a folder, show the command and its report, and return the command's text.

    Raises
    ------
    click.exceptions.Exit
        The command fails; the exit code is its own.
    """
    line = " ".join(("radiosity", *arguments))
    shown = not console().quiet
    if shown:
        click.echo(f"\n$ {line}", err=console().as_json)
    more = [] if shown and not console().as_json else ["--quiet"]
    more += ["--verbose"] if console().verbose and not more else []
    done = subprocess.run([sys.executable, "-m", "radiosity", *arguments, *more], cwd=folder, check=False)
    if done.returncode:
        raise click.exceptions.Exit(done.returncode)
    return line
