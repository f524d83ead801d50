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
                  help="Write the view factors to this .npz (scipy.sparse.load_npz reads F), .nc (netCDF), or "
                  "vfsparse.inp[.CASE] (lines i j F from 1, with svf.inp and facetarea.inp).")
    @click.option("--rays", type=AZIMUTHS, default="256x64", help="Set the number of rays of a hemisphere, powers of "
                  "two.")
    @click.option("--samples", type=click.IntRange(1, 16), default=1,
                  help="Set the number of Gauss points along each side of a patch.")
    @click.option("--facets", is_flag=True, help="Keep each face of a file as one patch, in the file's order; "
                  "its front alone radiates.")
    @click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.")
    @click.option("--max-area", type=Positive(), help="Cut patches until none is larger.")
    @method_option(FRUSTUM_METHODS, methods, default="grid", about="Choose how hemispheres are cast.")
    @METHOD_CELL
    @click.option("--resume", is_flag=True, help="Continue an unfinished run from the blocks of rows that it has kept "
                  "beside the output.")
    @add_options(option for method in methods for option in method.options)
    def formfactors(scene, output, rays, samples, facets, max_edge, max_area, method, cell, resume, **given):
        """Compute the form factors (view factors) between all patches of SCENE, with visibility.

        F[i, j] is the share of the light that leaves patch i and arrives at patch j. row_sums, N x samples^2, are
        integers in units of 2^-weight_bits: the share of each hemisphere whose rays met a patch.
        """
        chosen, options = options_of(methods, method, given)
        from golden.cast.methods import frustum_caster
        from golden.frustum import Hemisphere
        from golden.tasks.view_factors import ViewFactorTask

        hemisphere = Hemisphere(*rays)
        if chosen:
            chosen.check(frustum=(hemisphere.azimuths, hemisphere.polars), **options)
        task = ViewFactorTask(scene, output, facets=facets, max_edge=max_edge, max_area=max_area, resume=resume,
                              progress=console().progress)
        with (chosen.frusta(task.scene, cell=cell, **options) if chosen
              else nullcontext(frustum_caster(task.scene, method, cell=cell, progress=console().progress))) as caster:
            report, text = task.run(caster, method=method, whole=bool(chosen), rays=rays, samples=samples)
        if chosen:
            report[method] = caster.counts()
            text += f"\n{caster.summary()}"
        console().report(report, text)
    return formfactors
