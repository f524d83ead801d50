"""``schedule``: what the host prepares for a phase, and how well it fits."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import TOPOLOGIES
from radiosity.cli.parameters import ASSIGNMENTS, AZIMUTHS, CELL, FILE, PRESET, SCENE, SCENE_HELP, Numbers

__all__ = ["schedule_command"]

_NAMED = {"ratio": "--ratio", "clusters": "--clusters", "azimuths": "--rays", "polars": "--rays",
          "cell": "--cell", "capacity": "--capacity", "normal": "--normal"}


@click.command("schedule", cls=Task, named=_NAMED, short_help="Schedule a phase of castings.", epilog=SCENE_HELP)
@SCENE
@click.option("--clusters", type=int, default=8, help="Set the number of clusters, a power of two.")
@click.option("--ratio", type=int, default=64, help="Predict the work by a sparse casting: one ray of so many.")
@click.option("--origin", type=Numbers(), help="Set the reference point.  [default: the first of 16 on the ceiling]")
@click.option("--normal", type=Numbers(), help="Set the direction of the middle of its hemisphere.")
@click.option("--rays", type=AZIMUTHS, default="256x64", help="Set the number of rays of a hemisphere, powers of two.")
@CELL
@click.option("--ray-capacity", "--room", type=click.IntRange(min=1), help="Set the maximum number of rays of a "
              "cluster.  "
              "[default: no limit]")
@click.option("--capacity", type=click.IntRange(min=0), help="Set the maximum number of patches in a cluster's "
              "resident set.  [default: no limit]")
@click.option("--topology", type=click.Choice(TOPOLOGIES), help="Assign clusters with heavy traffic to near processors "
              "of this network.  [default: cluster i is processor i]")
@PRESET
@ASSIGNMENTS
@click.option("-o", "--output", type=FILE, help="Write the machine's memory image to this .bin.")
@click.option("--picture", type=FILE, help="Write the clusters' sections to this .png: azimuths run across, and pixels "
              "with more work are brighter.")
def schedule_command(scene, preset, assignments, output, picture, **options):
    """Schedule a phase of castings in SCENE from a sparse casting, and cast to see how well it fits."""
    from golden.base.output import check_outputs
    from golden.engine.config import PRESETS
    from radiosity.tasks.schedule import schedule_phase

    check_outputs(output, suffixes=(".bin",))
    check_outputs(picture, suffixes=(".png",))
    config = PRESETS[preset].with_parameters(assignments)
    console().report(*schedule_phase(scene, config, output=output, picture=picture, **options))
