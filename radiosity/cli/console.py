"""What a command prints: its report on stdout, everything else on stderr."""

import json
import sys
import warnings
from contextlib import contextmanager

import click

from golden.base.errors import InputError, InputWarning

__all__ = ["Console", "console"]

_KEY = "radiosity.cli.console"


class Console:
    """What the options ``--quiet``, ``--verbose`` and ``--json`` request.

    Members
    -------
    quiet, verbose, as_json, strict
        Whether the option was given.
    """

    def __init__(self):
        self.quiet = self.verbose = self.as_json = self.strict = False

    @property
    def progress(self) -> bool:
        """Whether bars are shown: on a terminal, and with ``--verbose`` anywhere."""
        return not self.quiet and (self.verbose or sys.stderr.isatty())

    def report(self, values: dict, text: str) -> None:
        """Print the result of a command: one JSON object, or the text if there is any."""
        if self.as_json:
            click.echo(json.dumps(values, indent=1, default=_plain))
        elif text and not self.quiet:
            click.echo(text)

    def note(self, text: str) -> None:
        """Say what is being done; only with ``--verbose``."""
        if self.verbose and not self.quiet:
            click.echo(text, err=True)

    def announce(self, text: str) -> None:
        """Say what is about to be done that takes long; on stderr, but with ``--quiet``."""
        if not self.quiet:
            click.echo(text, err=True)

    def warn(self, text: str) -> None:
        """Print a warning of one line."""
        click.echo("warning: " + " ".join(text.split()), err=True)

    @contextmanager
    def input_warnings(self):
        """Print each different warning on the input once; raise the first as an `InputError` if ``strict``."""
        shown = set()
        with warnings.catch_warnings():
            warnings.simplefilter("always", InputWarning)
            others = warnings.showwarning

            def show(message, category, *where, **more):
                if not issubclass(category, InputWarning):
                    others(message, category, *where, **more)
                elif self.strict:
                    raise InputError(str(message))
                elif str(message) not in shown:
                    shown.add(str(message))
                    self.warn(str(message))

            warnings.showwarning = show
            yield


def console() -> Console:
    """The console of the command that runs."""
    return click.get_current_context().meta.setdefault(_KEY, Console())


def _plain(value):
    """A path as text, a number of numpy as a number, an array as a list."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
