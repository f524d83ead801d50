"""What the host requests of a phase by its rules: clusters for each frustum, sections of equal work, subshell lists."""

from collections.abc import Sequence

import numpy as np

from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.frustum_cycles import frustum_cycles
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.tile_sections import most_sections
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.low_density import low_density
from golden.engine.schedule.phase import machine_schedule
from golden.engine.schedule.virtual_frusta import most_ratio

__all__ = ["phase_request", "sections_per_frustum"]

# Of each cluster, where several clusters share a frustum: results of one are written while the other is cast.
SECTIONS = 2


def sections_per_frustum(frusta: int, clusters: int) -> int:
    """Sections of a frustum: 1 if each cluster has a frustum of its own; otherwise as many as give each cluster the
    same number of sections, `SECTIONS` or a multiple.

    Parameters
    ----------
    frusta
        Frusta of the phase, at least 1.
    clusters
        Clusters of the machine, a power of two.
    """
    return 1 if frusta >= clusters else SECTIONS * clusters // (frusta & -frusta)


def phase_request(records: Sequence[FrustumRecord], geometry: PatchGeometry, table: CellTable, config: Config, *,
                  ratio: int, clusters: int | None = None, reference: FrustumRecord | None = None,
                  **results) -> PhaseRequest:
    """The request of a phase.

    Frusta that several clusters share are cut by the work that a sparse casting expects. Where the machine has subshell
    lists, the sparse casting makes them and chooses resident sets. Elsewhere cycles are predicted if the order of the
    queue matters: of more frusta than clusters, and of more clusters than one.

    Shadow frusta have no subshell lists, and are cut by their rays and positions: each of both counts as a half.

    Parameters
    ----------
    records, geometry, table
        The frusta, and patches and cells of the scene.
    config
        The machine's configuration.
    ratio
        Rays of the frustum for each ray of the sparse casting, or the most that have room in a block of the frustum.
    clusters
        Sections of each frustum that clusters share, a power of two. Default: `sections_per_frustum`. At most
        `most_sections`.
    reference
        The frustum of the sparse casting. Default: the first one.
    results
        ``weights``, ``hit_format``, ``sums`` of the request.

    Raises
    ------
    InputError
        See `golden.engine.schedule.phase.schedule` and `golden.engine.schedule.low_density.low_density`.
    """
    first, casting = records[0], config.noc.clusters
    clusters = sections_per_frustum(len(records), casting) if clusters is None else clusters
    clusters = min(clusters, most_sections(first.columns, first.rows, config))
    ratio = min(ratio, most_ratio(first.columns, first.rows))
    plan = workload = cycles = None
    is_shadow = first.bundle == Bundle.SHADOW
    if config.ctu.subshells and not is_shadow:
        plan = machine_schedule(reference or first, geometry, table, config, ratio=ratio)
    else:
        if clusters > 1 and is_shadow:
            workload = _rays_and_positions(records)
        elif clusters > 1:
            found = low_density(reference or first, geometry, table, config, ratio=ratio)
            workload = found.frusta.share(found.tests)
        if len(records) > casting > 1:
            cycles = frustum_cycles(records, geometry, table, config)
    return PhaseRequest(geometry=geometry, table=table, records=records, clusters=clusters, cycles=cycles,
                        workload=workload, plan=plan, **results)


def _rays_and_positions(records):
    """Rows x columns float64: of each position its share of all rays of shadow frusta, and of all positions."""
    size = len(records[0])
    rays = np.bincount(np.concatenate([record.listed for record in records]), minlength=size)
    return (rays / max(1, rays.sum()) + 1 / size).reshape(records[0].rows, records[0].columns)
