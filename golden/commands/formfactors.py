"""``formfactors``: form factors of a scene."""

from contextlib import nullcontext

import click

from golden.commands.casting_method import CastingMethod, add_options, method_option, options_of
from golden.commands.choices import FRUSTUM_METHODS
from golden.commands.command_line import Task
from golden.commands.console import console
from golden.commands.parameters import AZIMUTHS, FILE, METHOD_CELL, SCENE, SCENE_HELP, Positive

__all__ = ["formfactors_command"]

_NAMED = {"Azimuths": "--rays", "Polars": "--rays", "Cell size": "--cell", "Clusters": "--clusters"}


def formfactors_command(*methods: CastingMethod) -> click.Command:
    """The command, with methods that another package adds."""
    @click.command("formfactors", cls=Task, named=_NAMED, epilog=SCENE_HELP,
                   short_help="Compute form factors with visibility.")
    @SCENE
    @click.option("-o", "--output", type=FILE, required=True,
                  help="Write F, area, row_sums and weight_bits to this .npz.")
    @click.option("--rays", type=AZIMUTHS, default="256x64", help="Set the number of rays of a hemisphere, powers of "
                  "two.")
    @click.option("--samples", type=click.IntRange(1, 16), default=1,
                  help="Set the number of Gauss points along each side of a patch.")
    @click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.")
    @click.option("--max-area", type=Positive(), help="Cut patches until none is larger.")
    @method_option(FRUSTUM_METHODS, methods, default="grid", about="Choose how hemispheres are cast.")
    @METHOD_CELL
    @add_options(option for method in methods for option in method.options)
    def formfactors(scene, output, rays, samples, max_edge, max_area, method, cell, **given):
        """Compute the form factors between all patches of SCENE, with visibility.

        F[i, j] is the share of the light that leaves patch i and arrives at patch j. row_sums, N x samples^2, are
        integers in units of 2^-weight_bits: the share of each hemisphere whose rays met a patch.
        """
        chosen, options = options_of(methods, method, given)
        import numpy as np

        from golden.cast.methods import frustum_caster
        from golden.frustum import Hemisphere
        from golden.light.form_factors import patch_form_factors
        from golden.output import check_outputs, whole_file
        from golden.plural import counted
        from golden.scene.open import open_scene
        from golden.tasks.elements import cut_into_elements

        check_outputs(output, suffixes=(".npz",))
        hemisphere = Hemisphere(*rays)
        if chosen:
            chosen.check(frustum=(hemisphere.azimuths, hemisphere.polars), **options)
        cut = cut_into_elements(open_scene(scene), max_edge=max_edge, max_area=max_area)
        with (chosen.frusta(cut, cell=cell, **options) if chosen
              else nullcontext(frustum_caster(cut, method, cell=cell))) as caster:
            result = patch_form_factors(cut, caster, rays=rays, samples=samples, progress=console().progress)
        with whole_file(output) as part:
            np.savez(part, F=result.F, area=result.area, row_sums=result.row_sums, weight_bits=result.weight_bits)
        sums = result.row_sums / 2**result.weight_bits
        report = {"output": output, "scene": scene, "method": method, "elements": len(cut),
                  "least_share": float(sums.min()), "greatest_share": float(sums.max())}
        lines = [f"{output}: {counted(len(cut), 'element')}, hemispheres met a patch in "
                 f"{sums.min():.2%} to {sums.max():.2%}"]
        if chosen:
            report[method] = caster.counts()
            lines.append(caster.summary())
        console().report(report, "\n".join(lines))
    return formfactors
