"""Step plan: what the host decides at the start of a refinement step, from a low-density casting."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.schedule.low_density import low_density
from golden.engine.schedule.sections import Partition, cut_sections
from golden.engine.schedule.usage import usage_order
from radiosity.machines.paper.patch_tags import PatchTags, patch_tags, reached_sections
from radiosity.machines.paper.unit_pool import join_units, sector_cuts

__all__ = ["StepPlan", "plan_step"]


@dataclass(frozen=True, kw_only=True, eq=False)
class StepPlan:
    """Sections, clusters, tags and resident sets of a step.

    Parameters
    ----------
    partition
        The sections; cluster k casts section k.
    sectors
        Of each cluster the sectors of its traversal units.
    found
        The patches that the casting found, in order.
    tags
        Tags of all patches.
    resident
        Of each cluster the patches of its resident set, in the order in which the casting found them.
    """

    partition: Partition
    sectors: tuple[tuple[Sector, ...], ...]
    found: np.ndarray
    tags: PatchTags
    resident: tuple[np.ndarray, ...]


def plan_step(records: Sequence[FrustumRecord], shelling: Shelling, config: Config, *, clusters: int, units: int,
              ratio: int) -> StepPlan:
    """Plan a step.

    A cluster's resident set are the patches that the casting found and whose window meets the cluster's section; of
    more than half of ``memsys.own_patches`` those that the casting used most. The other half is for a cache.

    Parameters
    ----------
    records
        The frusta of the step; the casting is of the first one.
    shelling, config
        The scene, and its configuration.
    clusters, units
        Intersection units, a power of two, each of which is a cluster; and traversal units of the pool.
    ratio
        Rays of the frustum for each one of the low-density casting, a power of two.

    Raises
    ------
    InputError
        See `cut_sections`, `low_density` and `join_units`.

    Source: Shen & Deprettere, sections 1.3.1 to 1.3.3.
    """
    found = low_density(records[0], shelling.geometry, shelling.table, config, ratio=ratio)
    partition = cut_sections(found.frusta.share(found.tests), clusters=clusters, ray_capacity=config.icu.rays)
    steps = found.frusta.share(found.steps)
    joined = join_units(partition.sums(steps), partition.sections, units=units)
    reached = reached_sections(partition, found.window)
    resident = []
    for section in range(clusters):
        candidates = found.patches[reached[:, section]]
        best = usage_order(found.frequency[candidates])[:config.memsys.own_patches // 2]
        resident.append(candidates[np.sort(best)])
    windows = [PatchSetup(record, config).patches(shelling.geometry).window for record in records]
    return StepPlan(
        partition=partition, found=found.patches, tags=patch_tags(partition, windows), resident=tuple(resident),
        sectors=tuple(sector_cuts(steps, section, units=count) for section, count in zip(
            partition.sections, joined, strict=True)))
