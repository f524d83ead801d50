"""The command line: ``python -m golden COMMAND``."""

from golden.commands.cast import cast_command
from golden.commands.command_line import command_line
from golden.commands.config import show_config
from golden.commands.exchange import exchange_command
from golden.commands.formfactors import formfactors_command
from golden.commands.image import image_command
from golden.commands.intersect import intersect
from golden.commands.render import render_command
from golden.commands.scenes import export, list_scenes
from golden.commands.schedule import schedule_command
from golden.commands.stimulus import export_stimulus

__all__ = ["main"]


@command_line("radiosity-golden")
def main():
    """Run the golden model: scenes, casting, form factors and images, bit-exact with the machine."""


for _command in (show_config, export_stimulus, cast_command(), schedule_command, image_command, list_scenes, export,
                 intersect, formfactors_command(), exchange_command,
                 render_command(method="shelling", quality="sketch", size="256x256")):
    main.add_command(_command)
