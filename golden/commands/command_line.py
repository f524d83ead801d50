"""How a command line of this project ends: what goes wrong is one line on stderr."""

import sys

import click

from golden.errors import InputError

__all__ = ["CommandLine"]


class CommandLine(click.Group):
    """A group of commands in which whatever goes wrong is one line on stderr and exit code 2."""

    def main(self, *args, **kwargs):
        """Run a command and leave the interpreter with its exit code."""
        kwargs["standalone_mode"] = False
        try:
            super().main(*args, **kwargs)
        except click.Abort:
            _fail("interrupted", code=130)
        except click.UsageError as error:
            hint = f" Try '{error.ctx.command_path} --help'." if error.ctx else ""
            _fail(error.format_message() + hint)
        except click.ClickException as error:
            _fail(error.format_message())
        except InputError as error:
            _fail(str(error))
        except OSError as error:
            _fail(f"{error.filename or 'file'}: {error.strerror or error}")
        except MemoryError as error:
            _fail(f"not enough memory: {error}")
        sys.exit(0)


def _fail(message: str, *, code: int = 2) -> None:
    click.echo("error: " + " ".join(message.split()), err=True)
    sys.exit(code)
