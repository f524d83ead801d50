"""Prepared step: the golden model's work of a refinement step, which does not depend on times."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_hits import FixedHits, read_out
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record
from golden.engine.icu.patch_sums import SectionSums, section_sums
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.light.form_factors import gauss_points
from golden.scene.scene import Scene
from radiosity.machines.paper.refinement import Refinement
from radiosity.machines.paper.section_work import SectionCasting, SectionWork
from radiosity.machines.paper.step_plan import StepPlan, plan_step

__all__ = ["PreparedFrustum", "PreparedStep", "prepare_frustum", "prepare_steps"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedFrustum:
    """A frustum of a step.

    Parameters
    ----------
    record, hits
        The frustum, and the hits of its rays.
    works, sums
        Of each cluster the work of its section, and the sums of its rays' weights.
    """

    record: FrustumRecord
    hits: FixedHits
    works: tuple[SectionWork, ...]
    sums: tuple[SectionSums, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedStep:
    """A step.

    Parameters
    ----------
    source
        The patch that shoots.
    plan
        What the host has decided.
    frusta
        Its frusta, which are cast one after the other.
    """

    source: int
    plan: StepPlan
    frusta: tuple[PreparedFrustum, ...]


def prepare_steps(scene: Scene, config: Config, *, cell: float, hemisphere: Hemisphere, order: int, clusters: int,
                  units: int, ratio: int) -> Iterator[PreparedStep]:
    """Steps of progressive refinement without end.

    Parameters
    ----------
    scene, config
        What is cast into, and the configuration.
    cell
        Size of the cells.
    hemisphere, order
        Rays of a frustum; Gauss points along a side of the source patch, with a frustum each.
    clusters, units, ratio
        See `plan_step`.

    Raises
    ------
    InputError
        See `plan_step`, `gauss_points` and `Shelling`.
    """
    shelling = Shelling(PatchGeometry.of(scene, config.numbers), config, cell=cell)
    (points, shares), refinement = gauss_points(scene, order), Refinement(scene)
    for _ in count():
        source = refinement.choose()
        records = [hemisphere_record(hemisphere, shelling.geometry.coordinates, point, scene.normals[source],
                                     source=int(scene.surface[source])) for point in points[source]]
        plan = plan_step(records, shelling, config, clusters=clusters, units=units, ratio=ratio)
        frusta = tuple(prepare_frustum(shelling, record, config, plan, weights=hemisphere.weights)
                       for record in records)
        yield PreparedStep(source=source, plan=plan, frusta=frusta)
        factors = np.zeros(len(scene))
        for share, frustum in zip(shares[source], frusta, strict=True):
            for part in frustum.sums:
                factors[part.patch] += share * part.sum / 2**hemisphere.weight_bits
        refinement.shoot(source, factors)


def prepare_frustum(shelling: Shelling, record: FrustumRecord, config: Config, plan: StepPlan, *,
                    weights: np.ndarray) -> PreparedFrustum:
    """The work of a frustum on the clusters of a plan.

    Parameters
    ----------
    weights
        R int64, the weight of each ray.
    """
    memory = RayMemory(len(record), config)
    tests = shelling.tests(record, memory)
    works = tuple(SectionCasting(shelling, record, config, tests=tests, memory=memory, section=section,
                                 sectors=sectors).run()
                  for section, sectors in zip(plan.partition.sections, plan.sectors, strict=True))
    hits, owner = read_out(memory, record, tests.patches, config), plan.partition.cluster_map.ravel()
    order = np.argsort(owner, kind="stable")
    rays = np.split(order, np.searchsorted(owner[order], np.arange(1, len(works))))
    return PreparedFrustum(record=record, hits=hits, works=works,
                           sums=tuple(section_sums(hits.patch[own], weights[own]) for own in rays))
