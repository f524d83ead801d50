"""One frustum in the machine's integers, and how its hits compare."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from golden.base.output import whole_file
from golden.base.plural import counted
from golden.cast.grid import Grid
from golden.cast.methods import check_cell
from golden.engine.cast.differences import differences, oracle_rays
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.config import Config
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.engine.icu.inverse_distance import decode
from golden.engine.schedule.sections import cut_sections
from golden.light.image import label_colours, write_png
from golden.scene.open import open_scene

__all__ = ["cast_frustum"]

# Cell size of shelling.
CELL = 0.0625


def cast_frustum(scene: str, choice: FrustumChoice, config: Config, *, warn: Callable[[str], None],
                 method: str = "shelling", cell: float | None = None, clusters: int = 1, compare: tuple[str, ...] = (),
                 output: Path | None = None, picture: Path | None = None,
                 caster: Callable | None = None) -> tuple[dict, str, bool]:
    """Cast a frustum, compare its hits and write them.

    Parameters
    ----------
    scene
        A name as `open_scene` takes it.
    choice, config
        The frustum and the machine's configuration.
    warn
        Is called with a line for the user if the frustum points away from the scene.
    method
        ``shelling`` or ``naive``; another name needs ``caster``.
    cell, clusters
        Cell size as a share of the scene's longest side, by default `CELL`, and the clusters that share the frustum.
    compare
        ``naive`` and ``oracle``: with which references the hits are compared.
    output, picture
        Files for the hits (.npz) and for a picture of the patches that they are on (.png).
    caster
        Gives a `radiosity.tasks.machine_cast.MachineCastResult` of a record, a geometry and weights.

    Returns
    -------
    Counts and differences, ready for JSON, and as lines; and whether every comparison found what it must find.

    Raises
    ------
    InputError
        The scene, the frustum or a parameter cannot be used.
    """
    check_cell(method, cell)
    opened = open_scene(scene)
    record, geometry, weights = choice.record(opened, config)
    extra, text, agrees = {}, "", True
    if caster:
        outcome = caster(record, geometry, weights)
        hits, extra, text, agrees = outcome.hits, {method: outcome.report}, outcome.text, outcome.agrees
    elif method == "naive":
        hits = NaiveFixed(geometry, config).cast(record)
    else:
        sections = cut_sections(np.ones((record.rows, record.columns)), clusters=clusters).sections
        hits, counts = Shelling(geometry, config, cell=CELL if cell is None else cell).cast(record, sections)
        extra = _work(counts)
    report = {"scene": scene, "method": method, "rays": len(record), "hits": int((hits.patch >= 0).sum()), **extra,
              **_compare(compare, hits, record, opened, geometry, config)}
    if output:
        _write_hits(output, hits, record, geometry, config)
    if picture:
        write_png(picture, label_colours(hits.patch.reshape(record.rows, record.columns)))
    if report.get("naive", {}).get("differences") or report.get("oracle", {}).get("unexplained"):
        agrees = False
    warning = None if report["hits"] else choice.facing_away(opened)
    if warning:
        warn(warning)
    return report, "\n".join(filter(None, [_text(report), text])), agrees


def _write_hits(path, hits, record, geometry, config):
    t = np.divide(1, decode(hits.inverse, config.numbers), where=hits.inverse > 0, out=np.full(len(record), np.inf))
    with whole_file(path) as part:
        np.savez(part, patch=hits.patch, inverse=hits.inverse, u=hits.u, v=hits.v,
                 t=t / (geometry.coordinates.scale * record.z_scale * 2.0**-record.numbers.direction_fraction))


def _work(counts: list[ShellingCounts]) -> dict:
    """Counts of all clusters together, per ray and per patch, and those of each cluster if there are several."""
    total = sum(counts, ShellingCounts())
    work = {"tests_per_ray": total.tests / total.rays, "in_windows_per_ray": total.in_windows / total.rays,
            "cell_steps_per_ray": total.cell_steps / total.rays, "grid_rays": total.grid_rays, "cells": total.cells,
            "patches": total.patches, "edrc": total.edrc, "shells": total.shells}
    return work | ({"clusters": [asdict(cluster) for cluster in counts]} if len(counts) > 1 else {})


def _compare(references, hits, record, scene, geometry, config) -> dict:
    report = {}
    if "naive" in references:
        other = NaiveFixed(geometry, config).cast(record)
        report["naive"] = {"differences": len(hits.differences(other))}
    if "oracle" in references:
        other = Grid(scene).nearest(oracle_rays(record, geometry))
        report["oracle"] = differences(hits, other, record, scene, geometry, config).counts()
    return report


def _text(report: dict) -> str:
    lines = [f"{report['hits']} of {report['rays']} rays hit"]
    if "grid_rays" in report:
        lines += [f"per ray: {report['tests_per_ray']:.2f} tests, {report['in_windows_per_ray']:.2f} in windows, "
                  f"{report['cell_steps_per_ray']:.2f} cell steps",
                  f"{counted(report['shells'], 'shell')}, {counted(report['grid_rays'], 'grid ray')}, "
                  f"{counted(report['cells'], 'cell')}, {counted(report['patches'], 'patch')} found, "
                  f"{report['edrc']:.2f} tests per patch (EDRC)"]
        lines += [f"cluster {number}: {counted(cluster['rays'], 'ray')}, {counted(cluster['tests'], 'test')}, "
                  f"{counted(cluster['cell_steps'], 'cell step')}, {counted(cluster['patches'], 'patch')}"
                  for number, cluster in enumerate(report.get("clusters", ()))]
    lines += [f"{reference}: " + ", ".join(
        f"{count} {name.replace('_', ' ')}" for name, count in report[reference].items())
        for reference in ("naive", "oracle") if reference in report]
    return "\n".join(lines)
