"""``render``: an image whose radiosity hemispheres and primary rays are cast by the machine."""

import sys

import click

from golden.commands.parameters import FILE, SCENE_HELP, Positive, WholePair
from golden.errors import InputError
from golden.image import write_exr, write_png
from golden.light.tone import tone_map
from golden.light.two_pass import RenderSettings, render
from golden.output import check_outputs
from golden.scene.open import open_scene
from golden.scene.view import default_camera
from golden.summary import summary
from hw.simulator.machine_caster import MachineCaster
from tb.commands.machine_options import cell_option, machine_config, machine_options, open_rig, stats_option, write_json

__all__ = ["render_image"]

# What the machine casts; the host casts the other kinds.
MACHINE_KINDS = ("hemisphere", "primary")


@click.command("render", epilog=SCENE_HELP)
@click.argument("scene")
@click.option("-o", "--output", type=FILE, required=True, multiple=True,
              help="Image: .png (what a display shows) or .exr (linear radiance). May be repeated.")
@click.option("--size", type=WholePair("WIDTHxHEIGHT"), default="128x128", help="Of the image.")
@click.option("--spp", "samples", type=int, default=1, help="Primary rays per pixel.")
@click.option("--light-samples", type=int, default=RenderSettings.light_samples,
              help="Shadow rays to area lights per point.")
@click.option("--depth", type=int, default=RenderSettings.depth, help="Mirror and glass surfaces in a row.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="64x16",
              help="Rays of a radiosity hemisphere, powers of two.")
@click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.  [default: some 3000 elements]")
@click.option("--seed", type=int, default=RenderSettings.seed, help="Of all random choices.")
@cell_option
@machine_options
@stats_option
def render_image(scene, output, size, samples, light_samples, depth, rays, max_edge, seed, cell, stats, **machine):
    """Make an image of SCENE: indirect light by radiosity, everything else by ray tracing.

    The machine casts the hemispheres and the primary rays, the host shades and casts shadow, mirror and glass rays: the
    same bytes as `python -m golden render --method shelling` with the same options.
    """
    check_outputs(*output, suffixes=(".png", ".exr"))
    check_outputs(stats, suffixes=(".json",))
    settings = RenderSettings(width=size[0], height=size[1], samples=samples, light_samples=light_samples, depth=depth,
                              rays=rays, max_edge=max_edge, seed=seed, method="shelling")
    config, opened = machine_config(**machine), open_scene(scene)
    if size[0] * size[1] * settings.side**2 > config.noc.nodes * config.icu.rays:
        raise InputError(f"machine: Size times samples must be at most {config.noc.nodes * config.icu.rays} rays "
                         f"(icu.rays, --clusters), not {size[0] * size[1] * settings.side**2}")
    with open_rig(config, **machine) as machine:
        frusta = MachineCaster(opened, machine, cell=cell)
        result = render(opened, camera=default_camera(opened), settings=settings, frusta=frusta,
                        progress=sys.stderr.isatty())
    for path in output:
        if path.suffix.lower() == ".exr":
            write_exr(path, result.image)
        else:
            write_png(path, tone_map(result.image, exposure=None, curve="reinhard", gamma=None))
    rays_of = {kind: counts["rays"] for kind, counts in result.stats["rays"].items()}
    share = sum(rays_of.get(kind, 0) for kind in MACHINE_KINDS) / max(1, sum(rays_of.values()))
    if stats:
        write_json(stats, {**result.stats, "machine": {**frusta.counts(), "share": share}})
    click.echo(summary(result.stats))
    click.echo(f"\n{frusta.summary()}\n{share:.1%} of all rays on the machine")
