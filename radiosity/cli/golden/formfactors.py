"""``formfactors``: view factors of a scene."""

from contextlib import nullcontext

import click
from click.core import ParameterSource

from radiosity.cli.casting_method import add_options, machine_options, method_of, method_option, options_of
from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import FRUSTUM_METHODS, LENGTH_UNITS, RAY_METHODS, SKY_DIVISIONS
from radiosity.cli.golden.factor_outputs import FACTOR_OUTPUT_NAMES, FACTOR_OUTPUTS
from radiosity.cli.parameters import AZIMUTHS, FILE, LEAST_RAYS, METHOD_CELL, SCENE, SCENE_HELP, ZENITH, Positive
from radiosity.cli.workers import WORKERS, worker_pool

__all__ = ["formfactors_command"]

_NAMED = {"azimuths": "--rays", "polars": "--rays", "cell": "--cell", "clusters": "--clusters",
          "error": "--error", "sky_error": "--sky-error", "seed": "--seed", "jobs": "--jobs",
          "zenith": "--zenith", "period": "--period", "least": "--least-rays"}
_TASK = *FACTOR_OUTPUT_NAMES, "zenith", "facets", "unit", "max_edge", "max_area"
"""The options that the task takes as they are."""

_ADAPTIVE = {"error": "--error", "sky_error": "--sky-error", "sky_patches": "--sky-patches", "period": "--period",
             "seed": "--seed", "time_limit": "--time-limit"}


def formfactors_command(machine=None) -> click.Command:
    """The command, with the simulated machine if it is given."""
    @click.command("formfactors", cls=Task, named=_NAMED, epilog=SCENE_HELP,
                   short_help="Compute form factors with visibility.")
    @SCENE
    @click.option("-o", "--output", type=FILE, required=True,
                  help="Write the view factors to this .npz (scipy.sparse.load_npz reads F), .nc (netCDF), or "
                  "vfsparse.inp[.CASE] (lines i j F from 1, with svf.inp and facetarea.inp).")
    @add_options(FACTOR_OUTPUTS)
    @click.option("--error", type=Positive(), default=1e-3, help="Set the largest estimated error of any factor, twice "
                  "its standard error: 1e-6 to 0.1.")
    @click.option("--sky-error", type=Positive(), help="Set the largest estimated error of any sky view factor.  "
                  "[default: that of the factors, as far as 4096 rays per patch reach]")
    @click.option("--sky-patches", type=click.Choice(SKY_DIVISIONS), help="Also write the shares of Tregenza's 145 "
                  "or Reinhart's 577 patches of the sky around the zenith; the north is +y, or -z if +y is the zenith.")
    @ZENITH
    @click.option("--time-limit", type=Positive(), help="Stop at a larger error after about so many seconds.")
    @click.option("--seed", type=int, default=0, help="Set the seed of all random choices.")
    @click.option("--rays", type=AZIMUTHS, help="Cast plain hemispheres of so many rays, powers of two, at fixed "
                  "points instead.  [default: 256x64 where the method casts no single rays]")
    @click.option("--samples", type=click.IntRange(1, 16), help="Set the number of these points along each side of a "
                  "patch.  [default: 1]")
    @LEAST_RAYS
    @click.option("--project", is_flag=True, help="Close the rows of plain hemispheres and make them reciprocal.")
    @click.option("--facets", is_flag=True, help="Keep each face of a file as one row, in the file's order; "
                  "its front alone radiates.")
    @click.option("--unit", type=click.Choice(LENGTH_UNITS), default="m", help="Name the scene's unit of length; areas "
                  "are written in m2.")
    @click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.")
    @click.option("--max-area", type=Positive(), help="Cut patches until none is larger.")
    @method_option(FRUSTUM_METHODS, machine, default=None, about="Choose how rays are cast.")
    @METHOD_CELL
    @click.option("--jobs", type=int, help="Set the number of threads that cast; view factors do not depend on it.  "
                  "[default: one per usable processor]")
    @click.option("--resume", is_flag=True, help="Continue an unfinished run from the blocks of rows that it has kept "
                  "beside the output.")
    @WORKERS
    @add_options(machine_options(machine))
    def formfactors(scene, output, error, sky_error, sky_patches, time_limit, seed, rays, samples, least_rays,
                    project, method, cell, jobs, resume, workers, **given):
        """Compute the form factors (view factors) between all patches of SCENE, with visibility.

        F[i, j] is the share of the light leaving patch i that arrives at patch j. Rows sum to 1 minus the shares that
        leave for the sky and that meet the backs of one-sided patches, and A[i] F[i, j] = A[j] F[j, i], both within
        1e-9. With --rays, or a method that casts no single rays, F is what plain hemispheres met, and row_sums are
        integers in units of 2^-weight_bits.
        """
        method = method_of(method, counts_cells=cell is not None)
        chosen, options = options_of(machine, method, given)
        plain = method not in RAY_METHODS or rays is not None or samples is not None
        _check_options(plain, method, project, time_limit, resume, least_rays)
        if sky_patches and output.suffix.lower() not in (".npz", ".nc"):
            raise click.UsageError("--sky-patches needs an output that ends in .npz or .nc.")
        if given["receivers"] and method not in RAY_METHODS:
            raise click.UsageError(f"--receivers needs single rays: {', '.join(RAY_METHODS)}.")
        if given["zenith"] and not (sky_patches or given["period"]):
            raise click.UsageError("--zenith needs --sky-patches or --period: nothing else depends on it.")
        pool = worker_pool(workers, method, chosen, cell=cell)
        from golden.cast.density import Density
        from golden.cast.hemisphere import Hemisphere
        from golden.cast.methods import check_cell
        from golden.engine.cast.methods import frustum_caster
        from golden.light.factors.hemisphere_rows import HemisphereRows
        from radiosity.tasks.view_factors import ViewFactorTask

        check_cell(method, cell)
        rays, density = rays or (256, 64), None if least_rays is None else Density(least=least_rays)
        if chosen:
            hemisphere = Hemisphere(*rays)
            chosen.check(frustum=(hemisphere.azimuths, hemisphere.polars), **options)
        task = ViewFactorTask(scene, output, has_sky_patches=sky_patches is not None,
                              progress=console().progress, **{name: given[name] for name in _TASK})
        with (chosen.frusta(task.scene, cell=cell, **options) if chosen
              else nullcontext(frustum_caster(task.scene, method, cell=cell, jobs=jobs,
                                              progress=console().progress))) as caster:
            def adaptive(error):
                return task.rows(caster, error=error, sky_error=sky_error, sky_patches=sky_patches, seed=seed)

            def spread(opened):
                return opened and opened.spread(task.scene, frusta=caster, rays=caster)

            if time_limit is not None:
                with pool as opened:
                    report, text = task.run_within(time_limit, adaptive, error=error, method=method,
                                                   spread=spread(opened))
            else:
                # The machine casts all frusta of a request as one job.
                rows = HemisphereRows(task.scene, caster, rays=rays, samples=samples or 1, density=density,
                                      projected=project, block_rows=len(task.scene) if chosen else 64,
                                      progress=console().progress and bool(chosen)) if plain else adaptive(error)
                store = task.store(rows, method=method, resume=resume)
                with pool as opened:
                    report, text = task.run(rows, store, method=method, spread=spread(opened))
            figures, more = task.receive(caster, error=error, seed=seed)
            report, text = {**report, **figures}, text + more
        if chosen:
            report[method] = caster.counts()
            text += f"\n{caster.summary()}"
        console().report(report, text)
    return formfactors


def _check_options(plain, method, project, time_limit, resume, least_rays):
    """Refuse options that exclude each other."""
    if least_rays is not None and method in RAY_METHODS:
        raise click.UsageError(f"--least-rays needs a method that casts no single rays, not {method}.")
    context = click.get_current_context()
    for name, option in _ADAPTIVE.items():
        if plain and context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            fixed = "--rays and --samples" if method in RAY_METHODS else f"--method {method}"
            raise click.UsageError(f"{option} excludes {fixed}.", context)
    if project and not plain:
        raise click.UsageError("--project needs --rays, --samples or a method with fixed rays: the others project "
                               "by themselves.", context)
    if context.params["drop_below"] and plain and not project:
        raise click.UsageError("--drop-below needs reciprocal factors: --project with these options.", context)
    if time_limit is not None and resume:
        raise click.UsageError("--time-limit and --resume exclude each other.", context)
