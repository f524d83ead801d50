"""``cast``: one frustum in the machine's integers, and how its hits compare."""

import sys

import click

from radiosity.cli.casting_method import add_options, machine_options, method_option, options_of, work_options
from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import RECORD_METHODS, REFERENCES
from radiosity.cli.parameters import (
    ASSIGNMENTS,
    AZIMUTHS,
    FILE,
    METHOD_CELL,
    PRESET,
    SCENE,
    SCENE_HELP,
    Numbers,
    WholePair,
    is_given,
)

__all__ = ["cast_command"]

_NAMED = {"patch": "--patch", "normal": "--normal", "azimuths": "--rays", "polars": "--rays", "width": "--screen",
          "height": "--screen", "cell": "--cell", "clusters": "--clusters", "ratio": "--ratio"}


_KINDS = ("hemisphere", "screen", "shadow")
# Options that a kind of frusta does not have.
_OTHERS = {"hemisphere": ("screen", "targets"), "screen": ("origin", "normal", "patch", "rays", "targets"),
           "shadow": ("normal", "rays", "screen", "picture")}


class References(click.ParamType):
    """Names of `REFERENCES`, separated by commas."""

    name = ",".join(REFERENCES)

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        names = value if isinstance(value, tuple) else tuple(value.split(","))
        for name in names:
            if name not in REFERENCES:
                self.fail(f"{name!r} is not one of {', '.join(REFERENCES)}", param, ctx)
        return names


def cast_command(machine=None) -> click.Command:
    """The command, with the simulated machine if it is given."""
    clusters_default = "1" if machine is None else f"1; the preset's with --method {machine.name}"

    @click.command("cast", cls=Task, named=_NAMED, epilog=SCENE_HELP,
                   short_help="Cast one hemisphere or screen, or shadow rays, in fixed point.")
    @SCENE
    @click.option("--kind", type=click.Choice(_KINDS), help="Choose the kind of rays. Shadow rays go from a point of a "
                  "light, --origin or the middle of --patch, to --targets.  [default: screen with --screen, else "
                  "hemisphere]")
    @click.option("--origin", type=Numbers(), help="Set the point where the rays start; a hemisphere needs --normal "
                  "too.")
    @click.option("--normal", type=Numbers(), help="Set the direction of the middle of the hemisphere.")
    @click.option("--patch", type=int, metavar="NUMBER",
                  help="Cast the hemisphere from the middle of this patch's front.")
    @click.option("--rays", type=AZIMUTHS, default="256x64", help="Set the number of rays of a hemisphere, powers of "
                  "two.")
    @click.option("--screen", type=WholePair("WIDTHxHEIGHT"), help="Cast a screen through the scene's view instead.")
    @click.option("--targets", type=FILE, help="Cast shadow rays to the points of this file: lines x y z nx ny nz, the "
                  "normals of their surfaces, or planes as of `render --sensors`.  [default: the middles of all "
                  "patches]")
    @method_option(RECORD_METHODS, machine, default="shelling",
                   about="Choose the casting method; all give the same hits.")
    @METHOD_CELL
    @click.option("--clusters", type=int,
                  help="Set the number of clusters that share the frustum, a power of two.  "
                  f"[default: {clusters_default}]")
    @click.option("--compare", type=References(), default=(), show_default=False,
                  help="Compare all hits with brute force in the machine's integers (naive) and in float64 (oracle).")
    @add_options(machine_options(machine, kind="frustum_options"))
    @PRESET
    @ASSIGNMENTS
    @click.option("-o", "--output", type=FILE,
                  help="Write the hits to this .npz: patch (-1: none), inverse (1/t as stored), t, u, v; of shadow "
                  "rays visible alone.")
    @click.option("--picture", type=FILE,
                  help="Write a .png with a colour for each patch, one pixel for each ray of the frustum's grid.")
    def cast(scene, kind, origin, normal, patch, rays, screen, targets, method, cell, clusters, compare, preset,
             assignments, output, picture, **given):
        """Cast one hemisphere or screen into SCENE in fixed point, as the machine does it, or shadow rays.

        Exits with code 1 if --compare finds a hit that differs from brute force in integers, or a difference from
        float64 that rounding does not explain.
        """
        _check_kind(kind, machine, targets=targets, screen=screen)
        if clusters is not None and method == "naive":
            raise click.UsageError("--clusters does not go with --method naive.")
        chosen, options = options_of(machine, method, given, kind="frustum_options")
        from golden.base.output import check_outputs
        from golden.engine.config import PRESETS
        from golden.engine.frustum.frustum_choice import FrustumChoice
        from radiosity.tasks.cast import cast_frustum

        check_outputs(output, suffixes=(".npz",))
        check_outputs(picture, suffixes=(".png",))
        config = PRESETS[preset].with_parameters(assignments)
        caster = None
        shared = {"clusters": clusters, "preset": preset, "assignments": assignments, **options}
        if chosen:
            chosen.check(**shared)
        if kind == "shadow":
            _cast_shadows(scene, config, chosen, shared, origin=origin, patch=patch, targets=targets, method=method,
                          cell=cell, compare=compare, output=output)
            return
        if chosen:
            def caster(record, geometry, weights):
                return chosen.cast(record, geometry, config, cell=cell, weights=weights, title=scene, **shared)
        choice = FrustumChoice(origin=origin, normal=normal, patch=patch, rays=rays, screen=screen)
        _report(*cast_frustum(scene, choice, config, warn=console().warn, method=method, cell=cell, compare=compare,
                              output=output, clusters=1 if clusters is None else clusters, picture=picture,
                              caster=caster))
    return cast


def _cast_shadows(scene, config, chosen, options, *, compare, cell, **given):
    """Cast shadow rays and report them."""
    from radiosity.tasks.shadows import cast_shadows

    if "oracle" in compare:
        raise click.UsageError("--compare oracle does not go with --kind shadow.")
    if options["clusters"] is not None and not chosen:
        raise click.UsageError("--clusters of --kind shadow needs --method machine.")

    def caster(opened):
        return chosen.frusta(opened, cell=cell, shadows=True, **options)
    _report(*cast_shadows(scene, config, compare=compare, cell=cell, caster=caster if chosen else None, **given))


def _report(report, text, agrees):
    """Print what was found; exit with code 1 unless all comparisons agree."""
    console().report(report, text)
    if not agrees:
        sys.exit(1)


def _check_kind(kind, machine, *, targets, screen):
    """Refuse options of other kinds of frusta."""
    if kind is None:
        if targets:
            raise click.UsageError("--targets needs --kind shadow.")
        if screen and is_given("rays"):
            raise click.UsageError("--rays does not go with --screen.")
        return
    others = {*_OTHERS[kind], *(work_options(machine) if kind == "shadow" else ())}
    for parameter in click.get_current_context().command.params:
        if parameter.name in others and is_given(parameter.name):
            raise click.UsageError(f"{parameter.opts[-1]} does not go with --kind {kind}.")
