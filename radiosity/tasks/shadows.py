"""Whether points see a point of a light, in the machine's integers."""

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from golden.base.errors import InputError, whole_number
from golden.base.finite_point import finite_point
from golden.base.output import whole_file
from golden.cast.methods import check_cell
from golden.cast.shadow_rays import ShadowRays
from golden.engine.cast.fixed_frusta import CONFIG, NaiveFixedFrusta, ShellingFrusta
from golden.engine.config import Config
from golden.light.photometry.sensor_file import read_sensors
from golden.light.photometry.sensors import Sensors
from golden.scene.open import open_scene
from golden.scene.scene import Scene

__all__ = ["cast_shadows", "shadow_rays"]


def shadow_rays(scene: Scene, *, origin=None, patch: int | None = None, targets: Sensors | None = None) -> ShadowRays:
    """Rays from a point of a light to shaded points.

    Parameters
    ----------
    scene
        The patches.
    origin, patch
        The point, or the patch in whose middle it is.
    targets
        The shaded points and the directions that their surfaces face. Default: the middles of all patches.

    Raises
    ------
    InputError
        Not exactly one of ``origin`` and ``patch`` is given, or one is wrong.
    """
    if (origin is None) == (patch is None):
        given = "none" if patch is None else "both"
        raise InputError(f"cast: one of --origin and --patch must be given, not {given}")
    if patch is None:
        point, surface = finite_point("cast: Origin", origin, parameter="origin"), -1
    else:
        patch = whole_number("cast: Patch", patch, 0, len(scene) - 1, parameter="patch")
        point, surface = scene.centres[patch], int(scene.surface[patch])
    position, normal = (scene.centres, scene.normals) if targets is None else (targets.position, targets.normal)
    return ShadowRays(points=point[None], surfaces=np.array([surface]), light=np.zeros(len(position), dtype=np.int64),
                      targets=position, normals=normal)


def cast_shadows(scene: str, config: Config, *, origin=None, patch: int | None = None, targets: Path | None = None,
                 method: str = "shelling", cell: float | None = None, compare: tuple[str, ...] = (),
                 output: Path | None = None, caster: Callable | None = None) -> tuple[dict, str, bool]:
    """Cast shadow rays, compare what blocks them and write which points are visible.

    Parameters
    ----------
    scene
        A name as `open_scene` takes it.
    config
        The machine's configuration.
    origin, patch
        See `shadow_rays`.
    targets
        A file of points as `golden.light.photometry.sensor_file.read_sensors` takes it. Default: the middles of all
        patches.
    method, cell
        ``shelling`` or ``naive``, and its cell size; another name needs ``caster``.
    compare
        ``naive``, or nothing.
    output
        File for ``visible`` (.npz).
    caster
        Gives, for the opened scene, a context manager of a caster of shadow frusta with ``counts()`` and ``summary()``;
        what it finds is compared with shelling.

    Returns
    -------
    Counts and differences, ready for JSON, and as lines; and whether no comparison found a difference.

    Raises
    ------
    InputError
        The scene, a point or a parameter cannot be used.
    """
    if config.numbers != CONFIG.numbers:
        raise InputError("cast: Number formats (numbers.*) must be the default ones for shadow rays")
    check_cell(method, cell)
    opened = open_scene(scene)
    rays = shadow_rays(opened, origin=origin, patch=patch, targets=read_sensors(targets) if targets else None)

    def golden(kind):
        return NaiveFixedFrusta(opened) if kind == "naive" else ShellingFrusta(opened, cell)

    with caster(opened) if caster else nullcontext(golden(method)) as frusta:
        hits = frusta.shadows(rays, least=1)
    visible = ~hits.blocked
    report = {"scene": scene, "method": method, "rays": len(rays), "visible": int(visible.sum()),
              "tests_per_ray": float(hits.tests.mean())}
    lines = [f"{report['visible']} of {report['rays']} points are visible, {report['tests_per_ray']:.2f} tests per ray"]
    counted = dict.fromkeys(compare) | ({method: "shelling"} if caster else {})
    for name, kind in counted.items():
        found = int((golden(kind or name).shadows(rays, least=1).blocked != hits.blocked).sum())
        report[name] = {"differences": found, **(frusta.counts() if kind else {})}
        lines += [frusta.summary()] if kind else []
        lines.append(f"{name}: {found} differences")
    if output:
        with whole_file(output) as part:
            np.savez(part, visible=visible)
    return report, "\n".join(lines), not any(report[name]["differences"] for name in counted)
