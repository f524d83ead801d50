"""Options of ``render`` for rows that are cast on demand."""

import click
from click.core import ParameterSource

from radiosity.cli.parameters import FILE, Positive

__all__ = ["SHOOTING", "SHOOTING_NAMED", "shooting_of"]

SHOOTING_NAMED = {"tolerance": "--shoot", "shooters": "--shooters", "shooting": "--shoot",
                  "preview_steps": "--preview-steps"}
SHOOTING = (
    click.option("--shoot", type=Positive(), metavar="SHARE", help="Cast the hemispheres of elements when they shoot, "
                 "the brightest ones first, until about this share of the light is missing (1e-6 to 0.5), in place of "
                 "--solver. Not with light from outside the scene."),
    click.option("--shooters", type=int, default=8, help="Set how many near elements with similar normals shoot in a "
                 "step of --shoot, 1 to 4096."),
    click.option("--overshoot/--no-overshoot", default=True, help="Choose whether elements also shoot in advance half "
                 "of what they expect to gain."),
    click.option("--preview", type=FILE, help="Write a picture of the elements between the steps of --shoot to this "
                 ".png."),
    click.option("--preview-steps", type=int, default=8, help="Set the number of steps from one of these pictures to "
                 "the next."))
_NEED = {"shooters": "--shooters", "overshoot": "--overshoot", "preview": "--preview"}


def shooting_of(given: dict) -> tuple:
    """The `Shooting` and the `Preview` of the options, or None of each; the options are taken out of ``given``.

    Raises
    ------
    click.UsageError
        An option is given without the one that it concerns.
    """
    from golden.light.preview import Preview
    from golden.light.solvers.on_demand import Shooting

    context = click.get_current_context()
    share, shooters, overshoot, path, steps = (given.pop(name) for name in (
        "shoot", "shooters", "overshoot", "preview", "preview_steps"))

    def is_given(name):
        return context.get_parameter_source(name) is ParameterSource.COMMANDLINE

    for name, option in _NEED.items():
        if share is None and is_given(name):
            raise click.UsageError(f"{option} needs --shoot.", context)
    if share is not None and is_given("solver"):
        raise click.UsageError("--shoot and --solver exclude each other.", context)
    if path is None and is_given("preview_steps"):
        raise click.UsageError("--preview-steps needs --preview.", context)
    return (None if share is None else Shooting(tolerance=share, shooters=shooters, overshoot=overshoot),
            None if path is None else Preview(path, steps=steps))
