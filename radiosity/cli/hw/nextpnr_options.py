"""Options of nextpnr as an option of a command."""

import shlex

import click

__all__ = ["NEXTPNR_OPTIONS"]


class _NextpnrOptions(click.ParamType):
    """Options of nextpnr, split into words as a shell splits them."""

    name = "OPTIONS"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(shlex.split(value))
        except ValueError as error:
            self.fail(f"{value!r}: {error}", param, ctx)


NEXTPNR_OPTIONS = _NextpnrOptions()
