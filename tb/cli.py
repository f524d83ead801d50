"""The command line: ``python -m tb COMMAND``."""

import click

from golden.commands.command_line import CommandLine
from hw.host import EngineError, EngineTimeoutError
from tb.commands.cast import cast
from tb.commands.formfactors import formfactors
from tb.commands.render import render_image

__all__ = ["main"]


class MachineCommandLine(CommandLine):
    """In which the machine's errors are lines too."""

    def invoke(self, ctx):
        """Run a command."""
        try:
            return super().invoke(ctx)
        except (EngineError, EngineTimeoutError, RuntimeError) as error:
            if isinstance(error, click.exceptions.Exit):
                raise
            raise click.ClickException(f"machine: {error}") from error


@click.group(cls=MachineCommandLine, no_args_is_help=False,
             context_settings={"max_content_width": 110, "show_default": True})
@click.version_option(package_name="radiosity-engine", prog_name="tb")
def main():
    """Radiosity Engine, simulated: frusta, form factors and images whose hits the RTL has found."""


main.add_command(cast)
main.add_command(formfactors)
main.add_command(render_image)
