"""The command line: ``python -m golden COMMAND``."""

import json
import sys
from dataclasses import replace

import click
import numpy as np

from golden.cast.methods import FRUSTUM_METHODS, RAY_METHODS, frustum_caster
from golden.cast.ray_file import read_rays, write_hits
from golden.commands.cast import cast as cast_frustum
from golden.commands.command_line import CommandLine
from golden.commands.config import show_config
from golden.commands.parameters import FILE, SCENE_HELP, Positive, Triple, WholePair
from golden.commands.schedule import schedule_phase
from golden.commands.stimulus import export_stimulus
from golden.errors import InputError
from golden.image import false_colour, write_exr, write_png
from golden.light.form_factors import patch_form_factors
from golden.light.solvers import SOLVERS
from golden.light.tone import CURVES, tone_map
from golden.light.two_pass import RenderSettings, render
from golden.output import check_outputs, whole_file
from golden.scene.builtin import BUILTIN
from golden.scene.export import FORMATS, export_scene
from golden.scene.open import open_scene
from golden.scene.refine import refine
from golden.scene.view import default_camera
from golden.summary import summary

__all__ = ["main"]

_MOST_ELEMENTS = 1 << 14  # whose form factors take 2 GiB


@click.group(cls=CommandLine, no_args_is_help=False,
             context_settings={"max_content_width": 110, "show_default": True})
@click.version_option(package_name="radiosity-engine", prog_name="golden")
def main():
    """Radiosity Engine, golden model: scenes, casting, form factors and images; the machine bit for bit."""


main.add_command(show_config)
main.add_command(export_stimulus)
main.add_command(cast_frustum)
main.add_command(schedule_phase)


@main.command("scenes")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list instead of a table.")
def list_scenes(as_json):
    """List the built-in scenes."""
    rows = [{"name": entry.name, "patches": len(entry.make()), "default": entry.default,
             "sizes": [entry.sizes.start, entry.sizes.stop - 1] if entry.sizes else None, "about": entry.about}
            for entry in BUILTIN.values()]
    if as_json:
        click.echo(json.dumps(rows, indent=1))
        return
    click.echo(f"{'name':10} {'patches':>7}  {'size':12} what it is")
    for row in rows:
        size = f"{row['sizes'][0]}-{row['sizes'][1]} ({row['default']})" if row["sizes"] else "-"
        click.echo(f"{row['name']:10} {row['patches']:7}  {size:12} {row['about']}")
    click.echo("\nA size goes behind a colon, as in tetra:4; in brackets the default, to which the count belongs.")


@main.command("scene", epilog=SCENE_HELP)
@click.argument("scene")
@click.option("-o", "--output", type=FILE, required=True, help=f"File to write: {' '.join(FORMATS)}.")
def export(scene, output):
    """Write SCENE to a file that other programs read."""
    check_outputs(output, suffixes=FORMATS)
    opened = open_scene(scene)
    export_scene(opened, output)
    click.echo(f"{output}: {len(opened)} patches, {len(opened.materials)} materials")


@main.command(epilog=SCENE_HELP)
@click.argument("scene")
@click.argument("rays", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Hits: patch (-1: none), t, u, v. (.npz)")
@click.option("--method", type=click.Choice(list(RAY_METHODS)), default=RenderSettings.method,
              help="Casting method; the hits are the same.")
def intersect(scene, rays, output, method):
    """Cast RAYS (.npz with origin and direction, R x 3) into SCENE.

    With an array tmax (R) in RAYS the question is whether anything is nearer than that; any such hit will do.
    """
    check_outputs(output, suffixes=(".npz",))
    cast, any_hit = read_rays(rays)
    caster = RAY_METHODS[method](open_scene(scene))
    hits = caster.occluded(cast) if any_hit else caster.nearest(cast)
    write_hits(output, hits)
    count = max(1, len(cast))
    click.echo(f"{output}: {len(cast)} rays, {(hits.patch >= 0).sum()} hits, "
               f"{hits.tests.sum() / count:.2f} tests and {hits.steps.sum() / count:.2f} cell steps per ray")


def _elements(function):
    """Adds the options that cut patches into elements and choose how hemispheres are cast."""
    for option in (
            click.option("--method", type=click.Choice(list(FRUSTUM_METHODS)), default=RenderSettings.method,
                         help="How frusta are cast: hemispheres and primary rays."),
            click.option("--max-area", type=Positive(), help="Cut patches until none is larger."),
            click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.")):
        function = option(function)
    return function


@main.command(epilog=SCENE_HELP)
@click.argument("scene")
@click.option("-o", "--output", type=FILE, required=True, help="F, area, row_sums, weight_bits. (.npz)")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64",
              help="Rays of a hemisphere, powers of two.")
@click.option("--samples", type=click.IntRange(1, 16), default=1, help="Gauss points along each side of a patch.")
@_elements
def formfactors(scene, output, samples, rays, max_edge, max_area, method):
    """Compute the form factors between all patches of SCENE, with visibility.

    F[i, j] is the share of the light that leaves patch i and arrives at patch j. row_sums, N x samples^2, are integers
    in units of 2^-weight_bits: the share of each hemisphere whose rays met a patch.
    """
    check_outputs(output, suffixes=(".npz",))
    cut = _cut(open_scene(scene), max_edge, max_area)
    result = patch_form_factors(cut, frustum_caster(cut, method), rays=rays, samples=samples,
                                progress=sys.stderr.isatty())
    with whole_file(output) as part:
        np.savez(part, F=result.F, area=result.area, row_sums=result.row_sums, weight_bits=result.weight_bits)
    sums = result.row_sums / 2**result.weight_bits
    click.echo(f"{output}: {len(cut)} elements, hemispheres met a patch in {sums.min():.2%} to {sums.max():.2%}")


@main.command("render", epilog=SCENE_HELP)
@click.argument("scene")
@click.option("-o", "--output", type=FILE, required=True, multiple=True,
              help="Image: .png (what a display shows) or .exr (linear radiance). May be repeated.")
@click.option("--size", type=WholePair("WIDTHxHEIGHT"), default=f"{RenderSettings.width}x{RenderSettings.height}",
              help="Of the image.")
@click.option("--eye", type=Triple(), help="Where the camera is.  [default: the scene's view, or one of all of it]")
@click.option("--target", type=Triple(), help="Where it looks.")
@click.option("--up", type=Triple(), help="What is up in the image.")
@click.option("--fov", type=float, help="Full vertical field of view, degrees.")
@click.option("--sky", type=Triple("R,G,B", least=0), help="Radiance from outside the scene.  [default: the scene's]")
@click.option("--spp", "samples", type=int, default=RenderSettings.samples, help="Primary rays per pixel.")
@click.option("--light-samples", type=int, default=RenderSettings.light_samples,
              help="Shadow rays to area lights per point.")
@click.option("--depth", type=int, default=RenderSettings.depth, help="Mirror and glass surfaces in a row.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"),
              help="Rays of a radiosity hemisphere, powers of two.  [default: by the number of elements]")
@click.option("--solver", type=click.Choice(list(SOLVERS)), default=RenderSettings.solver, metavar="NAME",
              help=f"Of the radiosity system: {', '.join(SOLVERS)}.")
@_elements
@click.option("--cell", type=Positive(),
              help="Cell size of grid or shelling, share of the scene's longest side.  [default: the method's choice]")
@click.option("--jobs", type=int,
              help="Threads that cast; the image does not depend on it.  [default: one per processor]")
@click.option("--seed", type=int, default=RenderSettings.seed, help="Of all random choices.")
@click.option("--exposure", type=Positive(), help="Factor before the tone curve.  [default: automatic]")
@click.option("--tone", type=click.Choice(CURVES), default="reinhard", help="Tone curve.")
@click.option("--gamma", type=Positive(), help="Power law of the display.  [default: the sRGB curve]")
@click.option("--stats", type=FILE, help="Write counts and seconds. (.json)")
@click.option("--heatmap", type=FILE, metavar="PREFIX", help="Write PREFIX-tests.png and PREFIX-steps.png.")
def render_image(scene, output, size, eye, target, up, fov, sky, exposure, tone, gamma, stats, heatmap, **settings):
    """Make an image of SCENE: indirect light by radiosity, everything else by ray tracing."""
    settings = RenderSettings(width=size[0], height=size[1], **settings)
    heatmaps = [heatmap.with_name(f"{heatmap.name}-{what}.png") for what in ("tests", "steps")] if heatmap else []
    check_outputs(*output, suffixes=(".png", ".exr"))
    check_outputs(*heatmaps, suffixes=(".png",))
    check_outputs(stats, suffixes=(".json",))
    _distinct(*output, *heatmaps)
    opened = open_scene(scene, up=up)
    if sky is not None:
        opened = replace(opened, background=sky)
    result = render(opened, camera=_camera(opened, eye=eye, target=target, up=up, fov=fov), settings=settings,
                    progress=sys.stderr.isatty())
    for path in output:
        if path.suffix.lower() == ".exr":
            write_exr(path, result.image)
        else:
            write_png(path, tone_map(result.image, exposure=exposure, curve=tone, gamma=gamma))
    for path, values, what in zip(heatmaps, (result.tests, result.steps), ("patch tests", "cell steps"), strict=False):
        write_png(path, false_colour(values, f"{what} per pixel"))
    if stats:
        with whole_file(stats) as part:
            part.write_text(json.dumps(result.stats, indent=1) + "\n")
    click.echo(summary(result.stats))


def _cut(scene, max_edge, max_area):
    """The scene's elements as a scene; the patches themselves if no limit is given."""
    if max_edge is not None or max_area is not None:
        scene = refine(scene, max_edge=max_edge, max_area=max_area).scene
    if len(scene) > _MOST_ELEMENTS:
        raise InputError(f"form factors: there may be {_MOST_ELEMENTS} elements at most, not {len(scene)}")
    return scene


def _distinct(*paths):
    resolved = [path.resolve() for path in paths]
    for path in paths:
        if resolved.count(path.resolve()) > 1:
            raise InputError(f"output {str(path)!r}: it is named twice")


def _camera(scene, **changes):
    """The scene's view, or one of all of it, with the parts that the user gave."""
    return replace(default_camera(scene), **{name: value for name, value in changes.items() if value is not None})
