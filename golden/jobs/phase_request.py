"""What the host requests of a phase by its rules: clusters for each frustum, equal sections, resident sets."""

from collections.abc import Sequence

from golden.config import Config
from golden.frustum import FrustumRecord
from golden.jobs.job import PhaseRequest
from golden.jobs.tile_sections import most_sections
from golden.memsys.cell_table import CellTable
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.phase import machine_schedule

__all__ = ["clusters_per_frustum", "phase_request"]


def clusters_per_frustum(frusta: int, clusters: int) -> int:
    """1 if each cluster has a frustum of its own; otherwise the fewest that give each cluster the same number of
    sections.

    Parameters
    ----------
    frusta
        Frusta of the phase, at least 1.
    clusters
        Clusters of the machine, a power of two.
    """
    even = frusta & -frusta
    return 1 if frusta >= clusters else max(1, clusters // even)


def phase_request(records: Sequence[FrustumRecord], geometry: PatchGeometry, table: CellTable, config: Config, *,
                  ratio: int, clusters: int | None = None, reference: FrustumRecord | None = None,
                  **results) -> PhaseRequest:
    """The request of a phase.

    Frusta that several clusters share are cut by the work that a sparse casting expects. The same casting chooses
    resident sets where a cluster cannot hold all patches, and makes subshell lists where the machine has them.

    Parameters
    ----------
    records, geometry, table
        The frusta, and patches and cells of the scene.
    config
        The machine's configuration.
    ratio
        Rays of the frustum for each ray of the sparse casting.
    clusters
        Clusters for each frustum. Default: `clusters_per_frustum`. At most `most_sections`.
    reference
        The frustum of the sparse casting. Default: the first one.
    results
        ``weights``, ``hit_format``, ``sums``, ``cycles`` of the request.

    Raises
    ------
    InputError
        See `golden.schedule.phase.schedule`.
    """
    first, nodes = records[0], config.noc.nodes
    clusters = clusters_per_frustum(len(records), nodes) if clusters is None else clusters
    clusters = min(clusters, most_sections(first.columns, first.rows, config))
    needs_plan = config.ctu.subshells > 0 or len(geometry) > config.memsys.own_patches
    plan = None
    if needs_plan or clusters > 1:
        plan = machine_schedule(reference or first, geometry, table, config, ratio=ratio)
    return PhaseRequest(
        geometry=geometry, table=table, records=records, clusters=clusters, plan=plan if needs_plan else None,
        workload=None if clusters == 1 else plan.found.frusta.share(plan.found.tests), **results)
