"""``machine``: simulators of whole machines."""

from pathlib import Path

import click

from golden.commands.choices import HIT_FORMATS
from golden.commands.command_line import CommandLine, Task
from golden.commands.console import console
from golden.commands.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, SCENE, SCENE_HELP, WholePair

__all__ = ["machine"]


@click.group("machine", cls=CommandLine, no_args_is_help=False, short_help="Simulate machines of many clusters.")
def machine():
    """Simulate whole machines by discrete events, beyond what their hardware can be simulated with."""


@machine.command("engine", cls=Task, named={"Nodes": "--nodes", "Groups": "--groups"}, epilog=SCENE_HELP, extra="sim",
                 short_help="Simulate the engine with up to 1024 clusters.")
@SCENE
@click.option("--nodes", type=int, default=16, help="Set the number of clusters, a power of two up to 1024.")
@click.option("--groups", type=int, help="Set the number of groups that cast a frustum each, a power of two."
              "  [default: a group for each cluster, but no more than frusta]")
@click.option("--frusta", type=click.IntRange(1, 1 << 14), default=64, help="Cast this many hemispheres from points of "
              "the ceiling.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", help="Set the number of rays of each "
              "hemisphere.")
@METHOD_CELL
@click.option("--hits", type=click.Choice(HIT_FORMATS), default="none", help="Have hits of this format written "
              "beside the sums.")
@click.option("--latency", type=click.IntRange(1, 10_000), default=10, help="Set the latency of main memory in cycles.")
@click.option("--casts", type=click.Path(file_okay=False, path_type=Path), help="Keep the casts in this folder, for "
              "machines of other sizes.")
@PRESET
@ASSIGNMENTS
def engine(scene, nodes, groups, frusta, rays, cell, hits, latency, casts, preset, assignments):
    """Simulate a job of hemispheres on the engine, each cluster with all patches of SCENE.

    Cycles are compared with the hardware's up to 16 clusters; those of larger machines are extrapolated.
    """
    from golden.config import PRESETS
    from golden.jobs.result_formats import HitFormat
    from golden.progress_bar import progress_bar
    from radiosity.benchmarks.job_runs import JobSpec
    from radiosity.engine_machine import EngineMachine

    if groups is None:
        groups = min(nodes, 1 << (frusta.bit_length() - 1))
    spec = JobSpec(scene=scene, rays=rays, frusta=frusta, cell=cell, hit_format=HitFormat[hits.upper()])
    simulated = EngineMachine(spec, PRESETS[preset].with_parameters(assignments), latency=latency, folder=casts,
                              given=tuple(one.partition("=")[0] for one in assignments))
    with progress_bar(desc="cast", unit="section", delay=2, disable=not console().progress) as bar:
        run = simulated.run(nodes, groups, note=lambda done: bar.update(done - bar.n))
    report = run.report()
    console().report(report, _text(report))


def _text(report):
    each = report["of_a_node"]
    return "\n".join([
        f"{report['frusta']} hemispheres, {report['rays']} rays, cell {report['cell']:g}, {report['patches']} patches; "
        f"{report['nodes']} clusters in {report['groups']} groups, {report['sections']} sections",
        f"cycles {report['cycles']}" + " (extrapolated)" * report["is_extrapolated"]
        + f": load {report['load_cycles']}, casts {report['cast_cycles']:.0f} for each cluster; "
        f"efficiency {report['efficiency']:.3f}, {report['rays_per_cycle']:.3f} rays per cycle",
        "lower bounds: " + ", ".join(f"{name} {cycles}" for name, cycles in report["bounds"].items()),
        "memory port {port_share:.3f} and dispatcher {dispatch_share:.3f} of the cycles after the load".format(
            **report["traffic"]),
        *(f"{name.replace('_', ' ')} of a cluster: {counts['least']} to {counts['most']}, mean {counts['mean']:.1f}"
          for name, counts in each.items())])
