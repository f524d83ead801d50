"""Low-density casting: the distribution of a dense casting's work, from few of its rays and without intersections."""

from dataclasses import dataclass

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.inverse_distance import decode, inverse_distance
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.window import Window
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.memsys.patches.filter import Filter
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.virtual_frusta import VirtualFrusta

__all__ = ["LowDensity", "low_density"]


@dataclass(frozen=True, kw_only=True, eq=False)
class LowDensity:
    """Result of a low-density casting.

    Parameters
    ----------
    frusta
        The virtual frusta.
    tests
        V x U int64, intersection computations in each virtual frustum.
    steps
        V x U float64, cell traversal steps in each: those of a shell are divided evenly among the frusta alive in it.
    patches
        P int64, the patches found, in the order of discovery.
    shell
        P int64, the shell in which each was found; it does not decrease.
    window
        P windows of these patches in the frustum.
    frequency
        N int64, rays to be tested against each patch of the scene.
    passed, passed_window
        Q int64, patches of the same cells that are between the rays cast, in the order of discovery, and their windows.
    """

    frusta: VirtualFrusta
    tests: np.ndarray
    steps: np.ndarray
    patches: np.ndarray
    shell: np.ndarray
    window: Window
    frequency: np.ndarray
    passed: np.ndarray
    passed_window: Window


def low_density(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, *,
                ratio: int) -> LowDensity:
    """Cast one ray of every ``ratio``, shell by shell; a ray in the window of a patch counts as hit.

    Each ray cast represents the virtual frustum around it, so a window counts only if it holds all of this frustum. The
    hit is at the plane of the patch, unless that is farther than the patch's farthest vertex. A patch found in a shell
    counts as tested against all rays of its window in frusta whose hit may still change and is not nearer than the
    patch can be.

    Parameters
    ----------
    record
        The dense frustum.
    geometry, table
        Patches and cells of the scene.
    config
        The configuration.
    ratio
        Hi_Low_Ratio, a power of two; 1 casts all rays.

    Raises
    ------
    InputError
        The ratio is no power of two or leaves no ray.

    Source: Shen 1993, section 4.4.2.1. There a ray that is hit ends in the shell in which its patch was found, so a
    wall beside the origin hides half the scene.
    """
    frusta = VirtualFrusta.of(record.columns, record.rows, ratio)
    unit = CellTraversalUnit(record, table)
    cells, seen = Filter(len(table)), Filter(len(geometry))
    patches = PatchSetup(record, config).patches(geometry)
    nearest, farthest = _distances(record, geometry, patches, config)
    # Distance of the hit of each ray cast.
    distance = np.full(frusta.shape, np.inf)
    directions = record.directions(*frusta.rays)
    tests, steps = np.zeros(frusta.shape, dtype=np.int64), np.zeros(frusta.shape)
    frequency = np.zeros(len(geometry), dtype=np.int64)
    found, shells, passed = [], [], []
    for shell in range(1, unit.last_shell + 1):
        alive = distance > unit.settled(shell)
        if not alive.any():
            break
        before = unit.steps
        opened = cells.first(unit.open(shell, frusta.spread(alive)))
        steps += alive * ((unit.steps - before) / alive.sum())
        new = seen.first(table.patches.read(table.entries(opened)))
        overlap = frusta.overlaps(patches.window[new])
        cell, patch = (overlap.row, overlap.column), new[overlap.window]
        tested = alive[cell] & (distance[cell] >= nearest[patch])
        np.add.at(tests, cell, overlap.rays * tested)
        np.add.at(frequency, patch, overlap.rays * tested)
        hit = overlap.covers & tested
        cell, patch = (overlap.row[hit], overlap.column[hit]), patch[hit]
        plane = _distance(inverse_distance(patches.factor[patch], directions[cell], config.numbers), config)
        np.minimum.at(distance, cell, np.where(plane <= farthest[patch], plane, np.inf))
        found.append(new[frequency[new] > 0])
        shells.append(np.full(len(found[-1]), shell))
        passed.append(new[frequency[new] == 0])
    order, between = (np.concatenate(each).astype(np.int64) for each in (found, passed))
    return LowDensity(frusta=frusta, tests=tests, steps=steps, patches=order, shell=np.concatenate(shells),
                      window=patches.window[order], frequency=frequency, passed=between,
                      passed_window=patches.window[between])


def _distances(record, geometry, patches, config):
    """Bounds of the distances at which the rays of the windows can hit the patches: N float64 each, in R units of 1."""
    offset = geometry.vertices - record.origin
    if record.is_screen:
        farthest = offset @ record.matrix[2] * 2.0**-config.numbers.direction_fraction
    else:
        farthest = np.sqrt((offset * offset).sum(axis=2))
    # Bound of the rounding of vertices and directions.
    farthest = config.numbers.scene.decode(farthest.max(axis=1)) * (1 + 2.0**-12)
    return _distance(patches.bound, config), farthest


def _distance(stored, config):
    """Distances of stored inverse distances; 0 gives infinity."""
    inverse = decode(stored, config.numbers)
    return np.divide(1, inverse, out=np.full(len(inverse), np.inf), where=inverse > 0)
