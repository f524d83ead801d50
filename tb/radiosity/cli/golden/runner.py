"""Runs commands of the command line in this process."""

import json

from click.testing import CliRunner, Result

import radiosity.cli.golden.main

__all__ = ["report", "run"]


def run(*arguments) -> Result:
    """What a command returns."""
    return CliRunner().invoke(radiosity.cli.golden.main.main, [str(argument) for argument in arguments])


def report(*arguments) -> dict:
    """The object that a command prints with ``--json``."""
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)
