"""The command line: ``python -m golden COMMAND``."""

from radiosity.cli.command_line import command_line
from radiosity.cli.golden.cast import cast_command
from radiosity.cli.golden.config import show_config
from radiosity.cli.golden.exchange import exchange_command
from radiosity.cli.golden.formfactors import formfactors_command
from radiosity.cli.golden.image import image_command
from radiosity.cli.golden.intersect import intersect
from radiosity.cli.golden.render import render_command
from radiosity.cli.golden.scenes import export, list_scenes
from radiosity.cli.golden.schedule import schedule_command
from radiosity.cli.golden.stimulus import export_stimulus

__all__ = ["main"]


@command_line("radiosity-golden")
def main():
    """Run the golden model: scenes, casting, form factors and images, bit-exact with the machine."""


for _command in (show_config, export_stimulus, cast_command(), schedule_command, image_command, list_scenes, export,
                 intersect, formfactors_command(), exchange_command,
                 render_command(method="shelling", quality="sketch", size="256x256")):
    main.add_command(_command)
