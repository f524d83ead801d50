"""``intersect``: any rays of a file."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import RAY_METHODS
from radiosity.cli.parameters import FILE, SCENE, SCENE_HELP

__all__ = ["intersect"]


@click.command("intersect", cls=Task, short_help="Cast the rays of a file into SCENE.", epilog=SCENE_HELP)
@SCENE
@click.argument("rays", type=FILE)
@click.option("-o", "--output", type=FILE, required=True,
              help="Write the hits to this .npz: patch (-1: none), t, u, v.")
@click.option("--method", type=click.Choice(RAY_METHODS), default="grid",
              help="Choose the casting method; grid and naive give the same hits.")
def intersect(scene, rays, output, method):
    """Cast RAYS (.npz with origin and direction, R x 3) into SCENE.

    With an array tmax (R) in RAYS the question is whether anything is nearer than that; any such hit will do.
    """
    from golden.base.output import check_inputs_stay, check_outputs
    from golden.base.plural import counted
    from golden.cast import methods
    from golden.cast.ray_file import read_rays, write_hits
    from golden.scene.open import open_scene

    check_outputs(output, suffixes=(".npz",))
    check_inputs_stay(scene, rays, outputs=(output,))
    cast, any_hit = read_rays(rays)
    caster = methods.ray_caster(open_scene(scene), method, progress=console().progress)
    hits = caster.any_hit(cast) if any_hit else caster.nearest(cast)
    write_hits(output, hits)
    count = max(1, len(cast))
    report = {"output": output, "rays": len(cast), "hits": int((hits.patch >= 0).sum()),
              "tests_per_ray": float(hits.tests.sum() / count), "cell_steps_per_ray": float(hits.steps.sum() / count)}
    console().report(report, f"{output}: {counted(report['rays'], 'ray')}, {counted(report['hits'], 'hit')}, "
                     f"{report['tests_per_ray']:.2f} "
                     f"tests and {report['cell_steps_per_ray']:.2f} cell steps per ray")
