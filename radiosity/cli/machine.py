"""``machine``: simulators of whole machines."""

import sys
from pathlib import Path

import click
from click.core import ParameterSource

from radiosity.cli.command_line import CommandLine, Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import (
    GATHER_ASSIGNMENTS,
    GATHER_COMPLETIONS,
    GATHER_SCHEMES,
    GATHER_SOLVERS,
    HIT_FORMATS,
    KOAN_SCHEDULES,
    MERGE_DIVISIONS,
    MERGE_SCHEMES,
    TORUS_GROWTHS,
    TORUS_STORAGES,
    VOLUME_SPLITTERS,
)
from radiosity.cli.parameters import (
    ASSIGNMENTS,
    AZIMUTHS,
    CELL,
    FILE,
    METHOD_CELL,
    PRESET,
    SCENE,
    SCENE_HELP,
    WholePair,
    rays_option,
)

__all__ = ["machine"]

_SUPPLIES = ("pushed", "pulled", "main")
_NODES = click.option("--nodes", type=int, default=16, help="Set the number of nodes, a power of two up to 1024.")
_LATENCY = click.option("--latency", type=click.IntRange(1, 10_000), default=10,
                        help="Set the latency of main memory in cycles.")
_SIZE = click.option("--size", type=WholePair("WIDTHxHEIGHT"), default="512x512", help="Set the size of the screen.")
_PNG = click.option("-o", "--output", type=FILE, help="Write the picture to this file: .png.")
_STEPS = click.option("--steps", type=FILE, help="Write a picture of the regions after each step to this file: .png.")


@click.group("machine", cls=CommandLine, no_args_is_help=False, short_help="Simulate machines of many clusters.")
def machine():
    """Simulate whole machines by discrete events, beyond what their hardware can be simulated with."""


def _command(name, about, named, **options):
    """Make a function a command of the group.

    Parameters
    ----------
    name, about, options
        Its name, its line in the list of commands, and parameters of `Task`.
    named
        Values whose errors name an option: the value, and behind a colon the option if its name is another.
    """
    values = (word.partition(":") for word in named.split())
    return machine.command(name, cls=Task, short_help=about, **options,
                           named={value: f"--{option or value}" for value, _, option in values})


@_command("engine", "Simulate the engine with up to 1024 clusters.", "nodes groups", epilog=SCENE_HELP, extra="sim")
@SCENE
@click.option("--nodes", type=int, default=16, help="Set the number of clusters, a power of two up to 1024.")
@click.option("--groups", type=int, help="Set the number of groups that cast a frustum each, a power of two."
              "  [default: a group for each cluster, but no more than frusta]")
@click.option("--frusta", type=click.IntRange(1, 1 << 14), default=64, help="Cast this many hemispheres from points of "
              "the ceiling.")
@rays_option()
@METHOD_CELL
@click.option("--hits", type=click.Choice(HIT_FORMATS), default="none", help="Have hits of this format written "
              "beside the sums.")
@_LATENCY
@click.option("--casts", type=click.Path(file_okay=False, path_type=Path), help="Keep the casts in this folder, for "
              "machines of other sizes.")
@PRESET
@ASSIGNMENTS
def engine(scene, nodes, groups, frusta, rays, cell, hits, latency, casts, preset, assignments):
    """Simulate a job of hemispheres on the engine, each cluster with all patches of SCENE.

    Cycles are compared with the hardware's up to 16 clusters; those of larger machines are extrapolated.
    """
    from golden.base.progress_bar import progress_bar
    from golden.engine.config import PRESETS
    from golden.engine.jobs.result_formats import HitFormat
    from radiosity.machines.engine.engine_machine import EngineMachine
    from radiosity.machines.engine.job_runs import JobSpec

    if groups is None:
        groups = min(nodes, 1 << (frusta.bit_length() - 1))
    spec = JobSpec(scene=scene, rays=rays, frusta=frusta, cell=cell, hit_format=HitFormat[hits.upper()])
    simulated = EngineMachine(spec, PRESETS[preset].with_parameters(assignments), latency=latency, folder=casts,
                              given=tuple(one.partition("=")[0] for one in assignments))
    with progress_bar(desc="cast", unit="section", delay=2, disable=not console().progress) as bar:
        run = simulated.run(nodes, groups, note=lambda done: bar.update(done - bar.n))
    report = run.report()
    console().report(report, _engine_text(report))


@_command("paper", "Simulate the paper's machine with up to 1024 clusters.",
          "nodes traversal_units:units ratio samples cell azimuths:rays polars:rays", epilog=SCENE_HELP, extra="sim")
@SCENE
@click.option("--nodes", type=int, default=16, help="Set the number of intersection units, each of which is a cluster: "
              "a power of two up to 1024.")
@click.option("--units", type=int, help="Set the number of traversal units of the pool."
              "  [default: two for each cluster]")
@click.option("--supply", type=click.Choice(_SUPPLIES), default="pushed", help="Choose who moves patches: the host "
              "pushes them by tags, clusters pull them, or main memory alone has them.")
@click.option("--steps", type=click.IntRange(1, 1000), default=1, help="Cast this many refinement steps.")
@click.option("--samples", type=click.IntRange(1, 16), default=1, help="Cast hemispheres from this many points along "
              "each side of a step's patch.")
@rays_option()
@CELL
@click.option("--ratio", type=int, default=64, help="Cast one ray of so many at low density, a power of two.")
@_LATENCY
@PRESET
@ASSIGNMENTS
def paper(scene, nodes, units, supply, steps, samples, rays, cell, ratio, latency, preset, assignments):
    """Simulate refinement steps on the machine of Shen and Deprettere's paper in SCENE.

    Hits are compared with golden's. No cycles are compared with hardware, which there is none of.
    """
    from golden.engine.config import PRESETS
    from radiosity.machines.paper.paper_machine import PaperMachine, PaperSpec
    from radiosity.machines.paper.supply import Supply

    spec = PaperSpec(scene=scene, steps=steps, samples=samples, rays=rays, cell=cell, ratio=ratio)
    simulated = PaperMachine(spec, PRESETS[preset].with_parameters(assignments), nodes=nodes, units=units,
                             latency=latency)
    report = {**simulated.run(Supply(supply)).report(), "differences": simulated.differences()}
    console().report(report, _paper_text(report))
    if report["differences"]:
        sys.exit(1)


@_command("gather", "Simulate gathering on a hypercube of up to 1024 nodes.",
          "nodes patches memory azimuths:rays polars:rays completion seed", epilog=SCENE_HELP)
@SCENE
@_NODES
@click.option("--scheme", type=click.Choice(GATHER_SCHEMES), default="demand-driven", help="Choose who makes which "
              "row, and where patches are.")
@click.option("--assignment", type=click.Choice(GATHER_ASSIGNMENTS), help="Choose how patches are dealt before rows "
              "are made; the scheme demand-driven has none.  [default: random]")
@click.option("--granularity", type=click.IntRange(1, 1 << 14), help="Set the patches of a request of the scheme "
              "demand-driven.  [default: 1]")
@click.option("--seed", type=int, help="Set the seed of the assignment random.  [default: 0]")
@click.option("--solver", type=click.Choice(GATHER_SOLVERS), default="gauss-jacobi", help="Choose the solver.")
@click.option("--completion", type=click.Choice(GATHER_COMPLETIONS), help="Redistribute the matrix in equal shares, "
              "and complete split rows in this way.  [default: rows stay whole, where they were made]")
@click.option("--patches", type=int, help="Halve the largest patches until there are so many.")
@rays_option("64x32")
@click.option("--memory", type=int, default=4 << 20, help="Set the bytes of a node's memory.")
@click.option("--steps", type=FILE, help="Write a picture of the rows in the nodes over time to this file: .png.")
def gather(scene, nodes, scheme, assignment, granularity, seed, solver, completion, patches, rays, memory, steps):
    """Simulate form factors and radiosity of SCENE on a hypercube of nodes with memories of their own.

    The rows are golden's, whatever the scheme. Times are those of an iPSC/2, with our numbers of operations where
    its source has none.
    """
    from golden.base.errors import InputError
    from golden.base.output import check_outputs
    from golden.light.image import write_png
    from golden.scene.halve import halved
    from golden.scene.open import open_scene
    from radiosity.machines.common.assignment import check_nodes
    from radiosity.machines.gather.gather_machine import GatherMachine, row_frames
    from radiosity.machines.gather.node_memory import NodeMemory
    from radiosity.machines.gather.row_phase import GatherScheme

    check_outputs(steps, suffixes=(".png",))
    is_demanded = scheme == "demand-driven"
    if assignment is not None and is_demanded:
        raise InputError("--assignment needs --scheme circulation or --scheme sharing")
    if granularity is not None and not is_demanded:
        raise InputError("--granularity needs --scheme demand-driven")
    if seed is not None and (is_demanded or assignment not in (None, "random")):
        raise InputError("--seed needs --assignment random and --scheme circulation or --scheme sharing")
    chosen = GatherScheme(name=scheme, assignment=assignment or "random", granularity=granularity or 1, seed=seed or 0)
    if memory < 1:
        raise InputError(f"gather: Memory must be at least 1, not {memory}", parameter="memory")
    opened = open_scene(scene)
    opened = opened if patches is None else halved(opened, patches)
    check_nodes(nodes, len(opened))
    simulated = GatherMachine(opened, rays=rays, progress=console().progress)
    run = simulated.run(chosen, nodes=nodes, solver=solver, completion=completion, memory=NodeMemory(size=memory))
    if steps:
        write_png(steps, row_frames(run))
    report = {"scene": opened.name, **run.report()}
    console().report(report, _gather_text(report))


@_command("koan", "Simulate ray tracing in shared pages on up to 1024 nodes.",
          "nodes page_bytes:page cache item size width:size height:size cell azimuths:radiosity polars:radiosity",
          epilog=SCENE_HELP)
@SCENE
@_NODES
@click.option("--size", type=WholePair("WIDTHxHEIGHT"), default="128x128", help="Set the size of the picture in "
              "pixels.")
@click.option("--page", type=int, default=4096, help="Set the bytes of a page, a power of two.")
@click.option("--cache", type=int, default=2 << 20, help="Set the bytes of a node's cache for pages of other homes.")
@click.option("--item", type=int, default=3, help="Set the pixels along an item of work.")
@click.option("--schedule", type=click.Choice(KOAN_SCHEDULES), default="mixed", help="Choose who works on which item: "
              "tiles whose items are passed along a ring, tiles alone, or items dealt in turn.")
@CELL
@click.option("--offload", is_flag=True, help="Have a device beside each processor handle messages.")
@click.option("--radiosity", "rays", type=AZIMUTHS, help="Make form factors by hemispheres of so "
              "many rays, and solve for the radiosity, instead of a picture.")
@_PNG
@click.option("--pages", type=click.Path(dir_okay=False, path_type=Path), help="Write a chart of who holds which page "
              "over time to this .svg.")
@click.pass_context
def koan(context, scene, nodes, size, page, cache, item, schedule, cell, offload, rays, output, pages):
    """Simulate KOAN's machine: nodes that trace the rays of a picture of SCENE, which is in pages that they share.

    The picture does not depend on the machine. Times are those of an iPSC/2, with our numbers where its source has
    none.
    """
    from golden.base.errors import InputError
    from golden.base.output import check_outputs
    from golden.light.image import write_png
    from golden.scene.open import open_scene
    from radiosity.charts.chart import check_chart
    from radiosity.machines.koan.koan_machine import KoanMachine, KoanRadiosity
    from radiosity.machines.koan.koan_run import check_machine
    from radiosity.machines.koan.page_chart import LOG_ROWS, write_page_chart
    from radiosity.machines.koan.page_timing import PageTiming
    from radiosity.machines.koan.pixel_items import pixel_items
    from radiosity.machines.koan.scene_pages import check_page_bytes

    if rays is not None:
        for option in ("size", "item", "schedule", "output", "pages"):
            if context.get_parameter_source(option) is ParameterSource.COMMANDLINE:
                raise InputError(f"--{option} does not go with --radiosity, which makes no picture")

    check_outputs(output, suffixes=(".png",))
    check_chart(pages)
    check_page_bytes(page)
    check_machine(nodes, cache // page)
    timing = PageTiming(is_offloaded=int(offload))
    if rays is not None:
        opened = open_scene(scene)
        solved = KoanRadiosity(opened, rays=rays, cell=cell, page_bytes=page, progress=console().progress).run(
            nodes=nodes, frames=cache // page, timing=timing)
        report = {"scene": opened.name, "patches": len(opened), **solved.report()}
        console().report(report, _shared_text(report))
        return
    pixel_items(size, nodes, side=item, schedule=schedule)
    opened = open_scene(scene)
    simulated = KoanMachine(opened, size=size, cell=cell, progress=console().progress)
    run = simulated.run(nodes=nodes, page_bytes=page, frames=cache // page, side=item, schedule=schedule,
                        timing=timing, log=LOG_ROWS if pages else 0)
    if output:
        write_png(output, run.picture)
    if pages:
        write_page_chart(pages, run, title=f"{opened.name}, {nodes} nodes: holders of pages")
    report = {"scene": opened.name, "patches": len(opened), "width": size[0], "height": size[1],
              "rays": len(simulated.traced.pixel), "schedule": schedule, **run.report()}
    console().report(report, _koan_text(report))


def _koan_text(report):
    return "\n".join([
        f"{report['scene']}: {report['patches']} patches, {report['width']} x {report['height']} pixels, "
        f"{report['rays']} rays; {report['nodes']} nodes, schedule {report['schedule']}, {report['items']} items, "
        f"{report['passed_items']} passed on",
        f"{report['pages']} pages of {report['page_bytes']} bytes, {report['frames']} frames in each cache",
        f"seconds {report['seconds']:.3f}, alone {report['alone_seconds']:.3f}, efficiency {report['efficiency']:.3f}",
        f"{report['faults']} faults, miss ratio {report['miss_ratio']:.6f}, {report['fetched_bytes']} bytes fetched, "
        f"{report['drops']} pages dropped, {report['invalidations']} invalidations",
        "{messages} messages, {words} words; {ring_requests} requests for items, {ring_hops} hops".format(
            **report["traffic"]),
        *_node_lines(report, "node"),
        f"picture {report['picture']}"])


def _shared_text(report):
    return "\n".join([
        f"{report['scene']}: {report['patches']} patches; {report['nodes']} nodes, {report['steps']} steps of "
        "Gauss-Jacobi",
        f"seconds {report['seconds']:.3f}, form factors {report['form_factor_seconds']:.3f}",
        *("{phase}: {faults} faults, {fetches} pages fetched, {drops} dropped, {invalidations} invalidations, "
          "{recalls} recalls, {write_backs} written back".format(phase=name.replace("_", " "), **report[name])
          for name in ("form_factors", "solution")),
        f"F {report['F']}", f"radiosity {report['radiosity']}"])


@_command("merge", "Simulate pictures merged by up to 1024 nodes.", "nodes width:size height:size", epilog=SCENE_HELP)
@SCENE
@_NODES
@click.option("--scheme", type=click.Choice(MERGE_SCHEMES), default="aapc", help="Choose who sends pixels to whom: "
              "around a ring, along the rows and columns of a mesh, by pairs, or from each to all.")
@click.option("--division", type=click.Choice(MERGE_DIVISIONS), help="Choose how scanlines are divided among nodes."
              "  [default: packed, with --full equal]")
@click.option("--full", is_flag=True, help="Send the cells of all locations instead of the pixels that win in their "
              "node.")
@_SIZE
@_PNG
@_STEPS
def merge(scene, nodes, scheme, division, full, size, output, steps):
    """Simulate a picture of SCENE by nodes that each draw some polygons on the whole screen and merge their pixels.

    The picture is that of a plain z-buffer, lit from the eye. Times are those of an iPSC/2, with our numbers of
    operations where its source has none.
    """
    from golden.base.output import check_named_once, check_outputs
    from golden.light.image import write_png
    from golden.scene.open import open_scene
    from radiosity.machines.merge.merge_machine import MergeMachine
    from radiosity.machines.merge.merge_run import MergeScheme, check_machine

    check_outputs(output, steps, suffixes=(".png",))
    check_named_once(output, steps)
    chosen = MergeScheme(name=scheme, division=division or ("equal" if full else "packed"), is_full=full)
    check_machine(nodes, *size)
    opened = open_scene(scene)
    simulated = MergeMachine(opened, size=size)
    run, frames = simulated.run(chosen, nodes=nodes), simulated.frames(chosen, nodes=nodes) if steps else None
    if output:
        write_png(output, run.picture)
    if steps:
        write_png(steps, frames)
    report = {"scene": opened.name, **run.report()}
    console().report(report, _merge_text(report))


@_command("volume", "Simulate volumes drawn by regions on up to 1024 nodes.",
          "nodes width:size height:size grid seed mesh")
@_NODES
@click.option("--splitter", type=click.Choice(VOLUME_SPLITTERS), default="hs", help="Choose how the screen is split.")
@click.option("--mesh", type=int, help="Set the cells along each side of the mesh of the splitters mahd, hcs and gs."
              "  [default: 512 for mahd, 128 for hcs and gs, or what fits the screen]")
@click.option("--unweighted", is_flag=True, help="Count triangles alone when splitting, without spans and pixels.")
@click.option("--grid", type=int, nargs=3, default=(40, 32, 32), show_default=False, metavar="ALONG OUT UP",
              help="Set the points of the grid along the fin, outwards and upwards.  [default: 40 32 32]")
@click.option("--seed", type=int, default=0, help="Set the seed by which the fin and the direction of view are drawn.")
@_SIZE
@_PNG
@_STEPS
def volume(nodes, splitter, mesh, unweighted, grid, seed, size, output, steps):
    """Simulate a picture of the flow around a blunt fin by nodes that each draw a region of the screen.

    The picture has the same bytes for all splitters and numbers of nodes. Times are those of a Parsytec CC, with our
    numbers of operations where its source has none.
    """
    from golden.base.output import check_named_once, check_outputs
    from golden.light.image import write_png
    from radiosity.machines.merge.merge_machine import region_frames, volume_picture
    from radiosity.machines.merge.merge_run import check_machine
    from radiosity.machines.merge.screen_volume import drawn_direction, view_volume
    from radiosity.machines.merge.tetrahedra import blunt_fin
    from radiosity.machines.merge.volume_run import simulate_volume

    check_outputs(output, steps, suffixes=(".png",))
    check_named_once(output, steps)
    check_machine(nodes, *size)
    seen = view_volume(blunt_fin(grid, seed=seed), drawn_direction(seed), *size)
    run = simulate_volume(seen, splitter, nodes=nodes, is_weighted=not unweighted, mesh=mesh)
    if output:
        write_png(output, volume_picture(run))
    if steps:
        write_png(steps, region_frames(run))
    report = {"grid": list(grid), "seed": seed, **run.report()}
    console().report(report, _volume_text(report))


def _merge_text(report):
    return "\n".join([
        f"{report['scene']}: {report['triangles']} triangles, {report['pixels_generated']} pixels generated, "
        f"{report['pixels_of_the_picture']} in the picture; {report['nodes']} nodes, scheme {report['scheme']}, "
        f"division {report['division']}, " + ("all cells" if report["full"] else "active pixels"),
        f"seconds {report['seconds']:.3f}, efficiency {report['efficiency']:.3f}, imbalance of the merge "
        f"{report['imbalance']:.3f}",
        "span lists {span_lists:.3f} s, local pixels {local_pixels:.3f} s, merge {merge:.3f} s".format(
            **report["phases"]),
        "{messages} messages, {words} words, {concurrent_words} of them one after the other".format(
            **report["traffic"]),
        *_node_lines(report, "node"), f"picture {report['picture']}"])


def _volume_text(report):
    drawing = report["drawing"]
    return "\n".join([
        f"blunt fin {' x '.join(map(str, report['grid']))}, seed {report['seed']}: {report['faces']} triangles, "
        f"{report['pixels_of_the_picture']} pixels; {report['nodes']} nodes, splitter {report['splitter']}, "
        + ("triangles, spans and pixels" if report["weighted"] else "triangles alone"),
        f"seconds {report['seconds']:.3f}, speedup {report['speedup']:.2f}; splitting "
        f"{report['splitting_seconds']:.3f} s, drawing {drawing['seconds']:.3f} s, speedup {drawing['speedup']:.2f}",
        f"most over average triangles {report['balance']:.3f}, growth {100 * report['growth']:.1f} %",
        "{messages} messages, {words} words".format(**report["traffic"]),
        *_node_lines(report, "node"), f"picture {report['picture']}"])


@_command("torus", "Simulate rays that travel on a torus of up to 1024 nodes.",
          "nodes rows:size columns:size subdivisions:voxels growth delay seed buffer pixels:size", epilog=SCENE_HELP)
@SCENE
@click.option("--nodes", type=int, default=16, help="Set the number of nodes, a square number up to 1024.")
@click.option("--size", type=WholePair("ROWSxCOLUMNS"), default="150x150", help="Set the size of the picture.")
@click.option("--voxels", type=int, default=16, help="Set the voxels of a node along each axis.")
@click.option("--storage", type=click.Choice(TORUS_STORAGES), default="array", help="Choose how a node stores its "
              "voxels.")
@click.option("--growth", type=float, default=0.02, help="Set by which share of itself each node's box grows into its "
              "neighbours'.")
@click.option("--growth-by", type=click.Choice(TORUS_GROWTHS), default="axis", help="Choose what the growth is a share "
              "of.")
@click.option("--shadows/--no-shadows", default=True, help="Cast shadow rays, or none.")
@click.option("--steal/--no-steal", default=True, help="Have idle nodes request rows of pixels, or not.")
@click.option("--buffer", type=int, default=2048, help="Set the bytes of a link's buffer.")
@click.option("--delay", type=int, default=0, help="Set by how many microseconds messages are late at most.")
@click.option("--seed", type=int, default=0, help="Set the seed of delays and of the machine's own scenes.")
@_PNG
@click.option("--steps", type=click.Path(dir_okay=False, path_type=Path), help="Write who holds which ray over time to "
              "this .svg.")
def torus(scene, nodes, size, voxels, storage, growth, growth_by, shadows, steal, buffer, delay, seed, output, steps):
    """Simulate ray tracing of SCENE on a torus of nodes that each own a box of space.

    Besides those of all commands, scenes are spheres40, barroom367 and face954. The picture does not depend on the
    machine. Times are those of a VAX 11/780 of 1987.
    """
    from golden.base.output import check_outputs
    from golden.light.image import write_png
    from golden.scene.open import open_scene
    from radiosity.charts.chart import check_chart, write_figure
    from radiosity.machines.torus.torus_run import TorusSetup, simulate_torus
    from radiosity.machines.torus.torus_scene import torus_scene
    from radiosity.machines.torus.torus_scenes import TORUS_SCENES
    from radiosity.machines.torus.torus_steps import LOGGED, steps_figure

    check_outputs(output, suffixes=(".png",))
    check_chart(steps)
    setup = TorusSetup(nodes=nodes, size=size, subdivisions=voxels, storage=storage, growth=growth, growth_by=growth_by,
                       has_shadows=shadows, is_stealing=steal, buffer=buffer, delay=delay, seed=seed)
    opened = TORUS_SCENES[scene](seed) if scene in TORUS_SCENES else torus_scene(open_scene(scene))
    run = simulate_torus(opened, setup, log=LOGGED if steps else 0)
    if output:
        write_png(output, run.picture)
    if steps:
        write_figure(steps, steps_figure(run))
    report = run.report()
    console().report(report, _torus_text(report))


def _torus_text(report):
    traffic, each, visits = report["traffic"], report["per_ray"], report["visits"]
    return "\n".join([
        f"{report['scene']}: {report['objects']} objects, {report['rows']} x {report['columns']} pixels, "
        f"{report['rays']} rays, {report['shadow_rays']} of them shadow rays; {report['nodes']} nodes, "
        f"{report['subdivisions']} voxels along each axis, stored as {report['storage']}, boxes grown by "
        f"{report['growth']:g} of {report['growth_by']}",
        f"seconds {report['seconds']:.3f}, busiest node {report['busiest_seconds']:.3f}, efficiency "
        f"{report['efficiency']:.3f}",
        f"a ray: {each['tests']:.2f} tests, {each['steps']:.2f} steps, {each['compared']:.2f} references compared",
        "{passed} rays passed, {packets} packets of {values} values, {rows_given} rows given; {messages} messages, "
        "{busiest_link} on the busiest link".format(**traffic),
        "visits of the state packet to a node: " + ", ".join(f"{name} {most}" for name, most in visits.items()),
        *_node_lines(report, "node"),
        f"picture {report['picture']}"])


def _gather_text(report):
    factors, solution = report["form_factors"], report["solution"]
    iterations = ", ".join(map(str, solution["iterations"]))
    return "\n".join([
        f"{report['scene']}: {report['patches']} patches, {report['entries']} form factors; {report['nodes']} nodes, "
        f"scheme {report['scheme']}" + (f", assignment {report['assignment']}" if report["assignment"] else ""),
        f"seconds {report['seconds']:.3f}, efficiency {report['efficiency']:.3f}",
        f"form factors {factors['seconds']:.3f} s, efficiency {factors['efficiency']:.3f}, "
        f"{factors['rows_before_full']} rows before a memory was full",
        f"solution {solution['seconds']:.3f} s, efficiency {solution['efficiency']:.3f}, {report['solver']} in "
        f"{iterations} iterations; redistribution {solution['redistribution_seconds']:.3f} s, renumbering "
        f"{solution['renumbering_seconds']:.3f} s",
        "{messages} messages, {words} words, {circulated_words} of patches that travelled".format(**report["traffic"]),
        *_node_lines(report, "node"),
        f"F {report['F']}", f"radiosity {report['radiosity']}"])


def _paper_text(report):
    traffic, memory = report["traffic"], report["memory"]
    return "\n".join([
        f"{report['steps']} refinement steps, {report['frusta']} hemispheres, {report['rays']} rays, cell "
        f"{report['cell']:g}, {report['patches']} patches; {report['nodes']} clusters, {report['traversal_units']} "
        f"traversal units, patches {report['supply']}",
        f"cycles {report['cycles']}" + " (extrapolated)" * report["is_extrapolated"]
        + f"; efficiency {report['efficiency']:.3f}, {report['rays_per_cycle']:.3f} rays per cycle; "
        f"golden: {report['differences']} differences",
        f"tree: {traffic['pushed']} patches pushed, {traffic['requested']} requested, {traffic['dropped']} dropped, "
        f"root link {traffic['root_share']:.3f} of the cycles; {traffic['messages']} messages",
        f"references: {memory['resident_references']} to resident sets, {memory['cache_hits']} to caches, "
        f"{memory['main_references']} to main memory; at most {memory['most_held']} patches and "
        f"{memory['most_deferred']} deferred rays of a cluster",
        *_node_lines(report)])


def _node_lines(report, kind="cluster"):
    return [f"{name.replace('_', ' ')} of a {kind}: {counts['least']} to {counts['most']}, mean {counts['mean']:.1f}"
            for name, counts in report["of_a_node"].items()]


def _engine_text(report):
    return "\n".join([
        f"{report['frusta']} hemispheres, {report['rays']} rays, cell {report['cell']:g}, {report['patches']} patches; "
        f"{report['nodes']} clusters in {report['groups']} groups, {report['sections']} sections",
        f"cycles {report['cycles']}" + " (extrapolated)" * report["is_extrapolated"]
        + f": load {report['load_cycles']}, casts {report['cast_cycles']:.0f} for each cluster; "
        f"efficiency {report['efficiency']:.3f}, {report['rays_per_cycle']:.3f} rays per cycle",
        "lower bounds: " + ", ".join(f"{name} {cycles}" for name, cycles in report["bounds"].items()),
        "memory port {port_share:.3f} and dispatcher {dispatch_share:.3f} of the cycles after the load".format(
            **report["traffic"]),
        *_node_lines(report)])
