"""``render``: a picture of a scene."""

from contextlib import nullcontext

import click

from golden.base.plural import counted
from radiosity.cli.casting_method import add_options, machine_options, method_of, method_option, options_of
from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import CURVES, FIXED_METHODS, FRUSTUM_METHODS, SOLVERS
from radiosity.cli.golden.daylight_options import DAYLIGHT, DAYLIGHT_NAMED, daylight_of
from radiosity.cli.golden.photometric_options import PHOTOMETRIC, PHOTOMETRIC_NAMES
from radiosity.cli.golden.quality_options import quality_options
from radiosity.cli.golden.shooting_options import SHOOTING, SHOOTING_NAMED, shooting_of
from radiosity.cli.parameters import (
    AZIMUTHS,
    FILE,
    LEAST_RAYS,
    METHOD_CELL,
    SCENE,
    SCENE_HELP,
    ZENITH,
    Numbers,
    Place,
    Positive,
    WholePair,
)
from radiosity.cli.workers import WORKERS, worker_pool

__all__ = ["render_command"]

_NAMED = {"samples": "--spp", "width": "--size", "height": "--size", "size": "--size",
          "light_samples": "--light-samples", "noise": "--noise", "depth": "--depth", "elements": "--elements",
          "seed": "--seed", "memory": "--memory", "jobs": "--jobs", "azimuths": "--rays", "polars": "--rays",
          "cell": "--cell", "least_rays": "--least-rays", "least": "--least-rays",
          "fov": "--fov", "target": "--target", "up": "--up", "zenith": "--zenith", "clusters": "--clusters",
          "sensor_table": "--sensor-table", "decades": "--decades", "exposure": "--exposure", "gamma": "--gamma",
          **DAYLIGHT_NAMED, **SHOOTING_NAMED}


def render_command(machine=None, *, method: str | None = None, quality: str = "normal",
                   size: str = "512x512") -> click.Command:
    """The command, with the simulated machine if it is given, and defaults of some options."""
    @click.command("render", cls=Task, named=_NAMED, short_help="Make a picture of SCENE.", epilog=SCENE_HELP)
    @SCENE
    @click.option("-o", "--output", type=FILE, required=True, multiple=True,
                  help="Write the picture to this .png (as a display shows it) or .exr (linear radiance). May be "
                       "repeated.")
    @click.option("--size", type=WholePair("WIDTHxHEIGHT"), default=size, help="Set the size of the picture in "
                  "pixels.")
    @click.option("--eye", type=Numbers(), help="Set the position of the camera.  [default: the scene's view, or one "
                  "of all "
                  "of it]")
    @click.option("--target", type=Numbers(), help="Set the point that the camera looks at.")
    @click.option("--up", type=Numbers(), help="Set the direction that is up in the picture.")
    @ZENITH
    @click.option("--fov", type=float, help="Set the full vertical field of view in degrees.")
    @add_options(DAYLIGHT)
    @click.option("--luminaire", type=(FILE, Place()), multiple=True, metavar="FILE X,Y,Z[,TURN]",
                  help="Hang the luminaire of this .ies (LM-63) or .ldt (EULUMDAT) at a point, its C0 turned by TURN "
                  "degrees from x. May be repeated.")
    @add_options(quality_options(quality))
    @click.option("--spp", "samples", type=int, default=4, help="Set the number of primary rays per pixel: 1, 4, 9, "
                  "16 ... 1024.")
    @click.option("--light-samples", type=int, default=2, help="Set the number of shadow rays to area lights per "
                  "point.")
    @click.option("--noise", type=float, help="Cast pixels again, with four times the rays each time, until their "
                  "estimated relative error is at most this.")
    @click.option("--depth", type=int, default=6, help="Set the maximum number of mirrors and glass surfaces on a "
                  "path.")
    @click.option("--rays", type=AZIMUTHS, help="Set the number of rays of a radiosity hemisphere, powers of two.  "
                  "[default: by the "
                  "number of elements]")
    @LEAST_RAYS
    @click.option("--solver", type=click.Choice(SOLVERS), default="conjugate-gradient", metavar="NAME",
                  help=f"Choose the solver of the radiosity system: {', '.join(SOLVERS)}.")
    @add_options(SHOOTING)
    @click.option("--elements", type=int, default=3000, help="Set about how many elements the first pass has, unless "
                  "the scene is finer.")
    @click.option("--max-edge", type=Positive(), help="Cut patches until no edge is longer.  [default: by --elements]")
    @click.option("--max-area", type=Positive(), help="Cut patches until none is larger.")
    @method_option(FRUSTUM_METHODS, machine, default=method, about="Choose how frusta, hemispheres and primary rays, "
                   "are cast.")
    @METHOD_CELL
    @add_options(machine_options(machine))
    @click.option("--memory", type=int, help="Bound the megabytes that rays of the picture take at once, 64 or more.")
    @click.option("--jobs", type=int, help="Set the number of threads that cast; the picture does not depend on it.  "
                  "[default: one per usable processor]")
    @WORKERS
    @click.option("--seed", type=int, default=0, help="Set the seed of all random choices.")
    @click.option("--exposure", type=Positive(), help="Set the factor before the tone curve.  [default: automatic]")
    @click.option("--tone", type=click.Choice(CURVES), default="reinhard", help="Choose the tone curve.")
    @click.option("--gamma", type=Positive(), help="Set the exponent of the display's power law.  [default: the sRGB "
                  "curve]")
    @click.option("--bits", type=click.Choice(["8", "16"]), default="8", help="Set the bits of each channel of a .png.")
    @click.option("--stats", type=FILE, help="Write counts and seconds to this .json.")
    @click.option("--heatmap", type=FILE, metavar="PREFIX", help="Write the tests and the cell steps of each pixel to "
                  "PREFIX-tests.png and PREFIX-steps.png; grid casts unless --method names another one.")
    @add_options(PHOTOMETRIC)
    def render_image(scene, output, size, samples, light_samples, noise, depth, rays, least_rays, solver, elements,
                     max_edge, max_area, method, cell, memory, jobs, workers, seed, stats, heatmap, **given):
        """Make a picture of SCENE: indirect light by radiosity, everything else by ray tracing."""
        method = method_of(method, counts_cells=cell is not None or heatmap is not None)
        chosen, options = options_of(machine, method, given)
        daylight, (shooting, preview) = daylight_of(given), shooting_of(given)
        pool = worker_pool(workers, method, chosen, cell=cell)
        from golden.render.two_pass import RenderSettings
        from golden.scene.luminaires.luminaire import Luminaire
        from radiosity.tasks.photometry import Photometry
        from radiosity.tasks.render import RenderFiles, View, render_scene

        # The machine casts shelling's frusta.
        settings = RenderSettings(width=size[0], height=size[1], samples=samples, light_samples=light_samples,
                                  noise=noise, depth=depth, rays=rays, least_rays=least_rays, solver=solver,
                                  shooting=shooting, elements=elements, max_edge=max_edge, max_area=max_area,
                                  method="shelling" if chosen else method, cell=cell, memory=memory, jobs=jobs,
                                  seed=seed)
        photometry = Photometry(**{name: given[name] for name in PHOTOMETRIC_NAMES})
        files = RenderFiles(images=output, stats=stats, heatmap=heatmap, photometry=photometry, preview=preview,
                            bits=int(given["bits"]),
                            **{name: given[name] for name in ("exposure", "tone", "gamma")})
        view = View(**{name: given[name] for name in ("eye", "target", "up", "fov", "zenith", "sky")},
                    daylight=daylight, luminaires=tuple(Luminaire(path=path, place=place[:3], turn=place[3])
                                                        for path, place in given["luminaire"]))
        if chosen:
            chosen.check(frustum=tuple(settings.side * count for count in size), **options)

        def caster(opened):
            return chosen.frusta(opened, cell=cell, **options) if chosen else nullcontext()

        def estimate(hemispheres, seconds):
            # What is cast in numpy takes long enough to be announced.
            console().announce(f"{method}: {counted(hemispheres, 'hemisphere')} at most, about "
                               f"{max(1, round(hemispheres * seconds))} s; then the picture")
        with pool as opened:
            report, text = render_scene(scene, view, settings, files, method=method, caster=caster,
                                        workers=opened, progress=console().progress,
                                        estimate=estimate if method in FIXED_METHODS else None)
        console().report(report, text)
    return render_image
