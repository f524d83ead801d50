"""``formfactors``: form factors of a scene from the machine's hits."""

import sys

import click
import numpy as np

from golden.commands.parameters import FILE, SCENE_HELP, Positive, WholePair
from golden.frustum import Hemisphere
from golden.light.form_factors import patch_form_factors
from golden.output import check_outputs, whole_file
from golden.scene.open import open_scene
from golden.scene.refine import refine
from hw.simulator.machine_caster import MachineCaster
from tb.commands.machine_options import cell_option, machine_config, machine_options, open_rig

__all__ = ["formfactors"]


@click.command(epilog=SCENE_HELP)
@click.argument("scene")
@click.option("-o", "--output", type=FILE, required=True, help="F, area, row_sums, weight_bits. (.npz)")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="64x16", help="Of a hemisphere, powers of two.")
@click.option("--samples", type=click.IntRange(1, 16), default=1, help="Gauss points along each side of a patch.")
@click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.")
@cell_option
@machine_options
def formfactors(scene, output, rays, samples, max_edge, cell, **machine):
    """Compute the form factors between all patches of SCENE on the machine.

    The same bytes as `python -m golden formfactors --method shelling`. The machine's own sums of each hemisphere are
    compared with its hits.
    """
    check_outputs(output, suffixes=(".npz",))
    config, opened = machine_config(**machine), open_scene(scene)
    if max_edge is not None:
        opened = refine(opened, max_edge=max_edge).scene
    Hemisphere(*rays)  # says no before the machine is made
    with open_rig(config, **machine) as machine:
        frusta = MachineCaster(opened, machine, cell=cell)
        result = patch_form_factors(opened, frusta, rays=rays, samples=samples, progress=sys.stderr.isatty())
    with whole_file(output) as part:
        np.savez(part, F=result.F, area=result.area, row_sums=result.row_sums, weight_bits=result.weight_bits)
    sums = result.row_sums / 2**result.weight_bits
    click.echo(f"{output}: {len(opened)} elements, hemispheres met a patch in {sums.min():.2%} to {sums.max():.2%}")
    click.echo(frusta.summary())
