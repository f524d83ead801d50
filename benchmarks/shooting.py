"""Rows that shooting on demand casts until radiosities are right, beside all rows of a scene.

Patches shoot through a hemisphere from their middles, lamps too. The final radiosities are those of all rows.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from benchmarks.report import benchmark, provenance, table, write_report
from golden.cast.shared_caster import default_method
from golden.engine.cast.methods import frustum_caster
from golden.light.form_factors import PatchRows
from golden.light.solvers import SOLVERS, RadiositySystem
from golden.light.solvers.on_demand import Shooting
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from radiosity.cli.console import console

__all__ = ["ShotRow", "main", "shot_row"]

# Rays of a hemisphere.
SCENES = {"lobby": (256, 64), "room1627": (64, 16), "man": (64, 16)}
SHOOTERS, RMS, EXACT = 8, 0.01, 1e-9


@dataclass(frozen=True, kw_only=True)
class ShotRow:
    """What shooting takes until the area-weighted root of the mean square of all differences is `RMS`.

    Parameters
    ----------
    rows, cast
        All rows, and those that steps of several shooters with overshooting have cast.
    plain, grouped
        Shots of plain progressive refinement, and in steps of several shooters, both without overshooting.
    """

    rows: int
    cast: int
    plain: int
    grouped: int


class _Counted(RadiositySystem):
    """Counts the shots of each patch."""

    def columns(self, patches):
        self.shots[patches] += 1
        return super().columns(patches)


def shot_row(scene: Scene, rays: tuple[int, int], method: str) -> ShotRow:
    """What a scene takes; all its rows are cast first, since the final radiosities follow from them."""
    rows, area = PatchRows(scene, frustum_caster(scene, method), rays=rays).rows(np.arange(len(scene))), scene.areas
    columns = (sparse.diags_array(1 / area) @ rows.T @ sparse.diags_array(area)).tocsr()
    reflectance = sum(scene.channels(name) for name in ("diffuse", "specular", "transparent"))
    system = _Counted(form_factors=columns, reflectance=np.minimum(reflectance, 1), area=area,
                      emission=scene.channels("emission"), centre=scene.centres, normal=scene.normals)
    final = SOLVERS["gauss-seidel"](system, tolerance=EXACT).radiosity

    def shots(shooters, *, overshoot):
        system.shots = np.zeros(len(scene), dtype=np.int64)
        for state in Shooting(shooters=shooters, overshoot=overshoot).states(system):
            if (_square(area, state.radiosity + state.ambient - final) <= RMS**2 * _square(area, final)).all():
                return system.shots
        raise AssertionError("States never end")

    return ShotRow(rows=len(scene), cast=int((shots(SHOOTERS, overshoot=True) > 0).sum()),
                   plain=int(shots(1, overshoot=False).sum()), grouped=int(shots(SHOOTERS, overshoot=False).sum()))


def _square(area, values):
    return (area[:, None] * values ** 2).sum()


def _measured() -> Iterator[list]:
    for name, rays in SCENES.items():
        found = shot_row(open_scene(name), rays, default_method())
        yield [name, found.rows, found.cast, f"{found.cast / found.rows:.2f}", found.plain, found.grouped,
               f"{found.grouped / found.plain:.2f}"]
        console().note(f"{name}: {found.cast} of {found.rows} rows")


@benchmark("shooting")
def main() -> None:
    """Count the rows that shooting on demand casts until radiosities are within 1 % of their final values."""
    head = ["scene", "rows", "cast", "share", "plain shots", f"shots of {SHOOTERS}", "ratio"]
    write_report("Shooting on demand", provenance("numpy", "scipy"), table(head, list(_measured())))
