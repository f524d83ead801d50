"""``image``: a job for an exported core, as bytes of main memory."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import HIT_FORMATS
from radiosity.cli.parameters import AZIMUTHS, FILE, METHOD_CELL, SCENE, SCENE_HELP, Numbers, WholePair, is_given

__all__ = ["image_command"]

_NAMED = {"patch": "--patch", "normal": "--normal", "azimuths": "--rays", "polars": "--rays", "width": "--screen",
          "height": "--screen", "cell": "--cell"}


class _Address(click.ParamType):
    """A whole number from 0 on, decimal or with 0x."""

    name = "ADDRESS"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        try:
            number = int(value, 0) if isinstance(value, str) else value
        except ValueError:
            number = -1
        if number < 0:
            self.fail(f"{value!r} is not a whole number from 0 on, such as 0x80000000", param, ctx)
        return number


@click.command("image", cls=Task, named=_NAMED, short_help="Write a job for an exported core.", epilog=SCENE_HELP)
@SCENE
@click.option("--manifest", type=FILE, required=True, help="Read the parameters of the core from this "
              "radiosity_engine.json, which `radiosity verilog` has written.")
@click.option("--patch", "patches", type=int, multiple=True, metavar="NUMBER",
              help="Cast the hemisphere from the middle of this patch's front. May be repeated.")
@click.option("--every-patch", is_flag=True, help="Cast the hemispheres of all patches.")
@click.option("--origin", type=Numbers(), help="Set the point where the rays of a hemisphere start; needs --normal.")
@click.option("--normal", type=Numbers(), help="Set the direction of the middle of the hemisphere.")
@click.option("--screen", type=WholePair("WIDTHxHEIGHT"), help="Cast a screen through the scene's view instead.")
@click.option("--rays", type=AZIMUTHS, default="256x64", help="Set the number of rays of a hemisphere, powers of two.")
@METHOD_CELL
@click.option("--hits", type=click.Choice(HIT_FORMATS), default="full", help="Choose the format of the hits: 16 bytes "
              "a ray, 8 bytes, patch ids of 4 bytes, or none.")
@click.option("--sums", is_flag=True, help="Have the sums of the rays' weights written for each patch.")
@click.option("--base", type=_Address(), default=0, help="Set the first byte in main memory, rounded up to a multiple "
              "of 64.")
@click.option("--expected", is_flag=True, help="Also write the results that the core must leave, as text.")
@click.option("-o", "--output", "folder", type=FILE, default=Path("out/image"), help="Write job.bin, job.h and, with "
              "--expected, job.txt to this folder; they replace those of another job.")
def image_command(scene, manifest, patches, every_patch, origin, normal, screen, rays, cell, hits, sums, base, expected,
                  folder):
    """Write what main memory must hold before a core casts frusta into SCENE.

    job.bin has the rings, the descriptors and all tables, from the address --base on. job.h has the addresses as macros
    of C. A driver copies job.bin, sets the rings and the windows, and writes the number of descriptors into the
    doorbell. The core must have been reset before.
    """
    from radiosity.flow.job_image import ImageFrusta, write_image

    if screen and is_given("rays"):
        raise click.UsageError("--rays does not go with --screen.")
    frusta = ImageFrusta(patches=patches, every_patch=every_patch, origin=origin, normal=normal, screen=screen,
                         rays=rays)
    console().report(*write_image(scene, frusta, manifest, folder, cell=cell, base=base, hits=hits, sums=sums,
                                  expected=expected))
