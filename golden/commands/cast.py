"""``cast``: one frustum in the machine's integers, and how its hits compare."""

import json
import sys
from dataclasses import asdict

import click
import numpy as np

from golden.cast.differences import differences, oracle_rays
from golden.cast.fixed_hits import FixedHits
from golden.cast.grid import Grid
from golden.cast.naive_fixed import NaiveFixed
from golden.cast.shelling import Shelling, ShellingCounts
from golden.commands.parameters import ASSIGNMENTS, FILE, PRESET, SCENE_HELP, Positive, Triple, WholePair
from golden.config import PRESETS, Config
from golden.errors import InputError
from golden.frustum import FrustumRecord, Hemisphere, Screen, hemisphere_record, screen_record
from golden.icu.inverse_distance import decode
from golden.image import label_colours, write_png
from golden.output import check_outputs, whole_file
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene
from golden.scene.view import default_camera
from golden.schedule.sections import cut_sections

__all__ = ["asked_frustum", "cast"]

JUDGES = ("naive", "oracle")


class Judges(click.ParamType):
    """Names of `JUDGES`, separated by commas."""

    name = ",".join(JUDGES)

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        names = value if isinstance(value, tuple) else tuple(value.split(","))
        for name in names:
            if name not in JUDGES:
                self.fail(f"{name!r} is not one of {', '.join(JUDGES)}", param, ctx)
        return names


@click.command(epilog=SCENE_HELP)
@click.argument("scene")
@click.option("--origin", type=Triple(), help="Where the rays of a hemisphere start.")
@click.option("--normal", type=Triple(), help="The middle of the hemisphere.")
@click.option("--patch", type=int, metavar="NUMBER", help="Origin and normal: the middle of this patch's front.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", help="Of a hemisphere, powers of two.")
@click.option("--screen", type=WholePair("WIDTHxHEIGHT"), help="Cast a screen through the scene's view instead.")
@click.option("--method", type=click.Choice(["shelling", "naive"]), default="shelling",
              help="Casting method; the hits are the same.")
@click.option("--cell", type=Positive(), default=0.0625, help="Cell size, share of the scene's longest side.")
@click.option("--clusters", type=int, default=1, help="Clusters that share the frustum, a power of two.")
@click.option("--compare", type=Judges(), default=(), show_default=False,
              help="Compare all hits with the naive algorithm's and with float64.")
@PRESET
@ASSIGNMENTS
@click.option("-o", "--output", type=FILE, help="Hits: patch (-1: none), inverse (1/t as stored), t, u, v. (.npz)")
@click.option("--picture", type=FILE, help="A colour for each patch, rays as the frustum's grid has them. (.png)")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def cast(scene, origin, normal, patch, rays, screen, method, cell, clusters, compare, preset, assignments, output,
         picture, as_json):
    """Cast one hemisphere or screen into SCENE in fixed point, as the machine does it.

    --compare exits with code 1 if the naive algorithm gives anything else, or if a difference from float64 is not one
    of those that rounding explains.
    """
    check_outputs(output, suffixes=(".npz",))
    check_outputs(picture, suffixes=(".png",))
    config, opened = PRESETS[preset].with_parameters(assignments), open_scene(scene)
    record, geometry = asked_frustum(opened, config, origin, normal, patch, rays, screen)
    hits, counts = _cast(method, record, geometry, config, cell, clusters)
    report = {"rays": len(record), "hits": int((hits.patch >= 0).sum()), **_work(counts),
              **_compare(compare, hits, record, opened, geometry, config)}
    if output:
        t = np.divide(1, decode(hits.inverse, config.numbers), where=hits.inverse > 0, out=np.full(len(record), np.inf))
        with whole_file(output) as part:
            np.savez(part, patch=hits.patch, inverse=hits.inverse, u=hits.u, v=hits.v,
                     t=t / (geometry.coordinates.scale * record.z_scale * 2.0**-record.numbers.direction_fraction))
    if picture:
        write_png(picture, label_colours(hits.patch.reshape(record.rows, record.columns)))
    click.echo(json.dumps(report, indent=1) if as_json else _text(report))
    if report.get("naive", {}).get("differences") or report.get("oracle", {}).get("unexplained"):
        sys.exit(1)


def asked_frustum(scene: Scene, config: Config, origin, normal, patch, rays,
                  screen) -> tuple[FrustumRecord, PatchGeometry]:
    """What the options ask for: a hemisphere at a point or on a patch, or a screen."""
    given = [name for name, value in (("--origin", origin), ("--patch", patch), ("--screen", screen))
             if value is not None]
    if len(given) != 1:
        raise InputError("cast: one of --origin, --patch and --screen must be given, "
                         f"not {' and '.join(given) or 'none'}")
    if (origin is None) != (normal is None):
        raise InputError("cast: --origin and --normal must be given together")
    if screen:
        camera = default_camera(scene)
        geometry = PatchGeometry.of(scene, config.numbers, [camera.eye])
        return screen_record(Screen(camera=camera, width=screen[0], height=screen[1]), geometry.coordinates), geometry
    source = -1
    if patch is not None:
        if not 0 <= patch < len(scene):
            raise InputError(f"cast: Patch must be 0 to {len(scene) - 1}, not {patch}")
        origin, normal, source = scene.centres[patch], scene.normals[patch], int(scene.surface[patch])
    geometry = PatchGeometry.of(scene, config.numbers, [origin])
    return hemisphere_record(Hemisphere(*rays), geometry.coordinates, origin, normal, source=source), geometry


def _cast(method, record, geometry, config, cell, clusters) -> tuple[FixedHits, list[ShellingCounts]]:
    if method == "naive":
        return NaiveFixed(geometry, config).cast(record), []
    sections = cut_sections(np.ones((record.rows, record.columns)), clusters=clusters).sections
    return Shelling(geometry, config, cell=cell).cast(record, sections)


def _work(counts: list[ShellingCounts]) -> dict:
    """Counts of all clusters together, per ray and per patch, and those of each cluster if there are several."""
    if not counts:
        return {}
    total = sum(counts, ShellingCounts())
    work = {"tests_per_ray": total.tests / total.rays, "in_windows_per_ray": total.in_windows / total.rays,
            "cell_steps_per_ray": total.cell_steps / total.rays, "grid_rays": total.grid_rays, "cells": total.cells,
            "patches": total.patches, "edrc": total.edrc, "shells": total.shells}
    return work | ({"clusters": [asdict(cluster) for cluster in counts]} if len(counts) > 1 else {})


def _compare(judges, hits, record, scene, geometry, config) -> dict:
    report = {}
    if "naive" in judges:
        other = NaiveFixed(geometry, config).cast(record)
        report["naive"] = {"differences": len(hits.differences(other))}
    if "oracle" in judges:
        other = Grid(scene).nearest(oracle_rays(record, geometry))
        report["oracle"] = differences(hits, other, record, scene, geometry, config).counts()
    return report


def _text(report: dict) -> str:
    lines = [f"{report['hits']} of {report['rays']} rays hit"]
    if "edrc" in report:
        lines += [f"per ray: {report['tests_per_ray']:.2f} tests, {report['in_windows_per_ray']:.2f} in windows, "
                  f"{report['cell_steps_per_ray']:.2f} cell steps",
                  f"{report['shells']} shells, {report['grid_rays']} grid rays, {report['cells']} cells, "
                  f"{report['patches']} patches found, EDRC {report['edrc']:.2f}"]
    lines += [f"cluster {number}: {cluster['rays']} rays, {cluster['tests']} tests, "
              f"{cluster['cell_steps']} cell steps, {cluster['patches']} patches"
              for number, cluster in enumerate(report.get("clusters", ()))]
    lines += [f"{judge}: " + ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in report[judge].items())
              for judge in JUDGES if judge in report]
    return "\n".join(lines)
