"""Paper step: the cycles of refinement steps, from the push of patches to the last intensity message at the host."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from golden.engine.config import Config
from golden.engine.memsys.bus.cache import Cache
from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.cluster_memory import ClusterMemory
from radiosity.machines.paper.merge_tree import MergeTree, Messages
from radiosity.machines.paper.paper_cluster import ClusterCounts, PaperCluster
from radiosity.machines.paper.paper_timing import PaperTiming
from radiosity.machines.paper.patch_host import PatchHost
from radiosity.machines.paper.prepared_step import PreparedStep
from radiosity.machines.paper.supply import Supply

__all__ = ["PaperStep", "simulate_steps"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperStep:
    """A step that has been simulated.

    Parameters
    ----------
    prepared
        Its work.
    cycles
        From its start to the last message at the host.
    counts, memories
        Of each cluster; the latter as they are at the end.
    pushed, replies, link_words, root_cycles
        See `PatchHost`.
    sums
        Of each frustum the messages at the host.
    """

    prepared: PreparedStep
    cycles: int
    counts: tuple[ClusterCounts, ...]
    memories: tuple[ClusterMemory, ...]
    pushed: int
    replies: int
    link_words: int
    root_cycles: int
    sums: tuple[Messages, ...]


def simulate_steps(steps: Iterable[PreparedStep], config: Config, timing: PaperTiming, *,
                   supply: Supply) -> list[PaperStep]:
    """Simulate steps one after the other; clusters keep what they hold and still need.

    Parameters
    ----------
    steps
        Their work, all on as many clusters.
    config, timing
        ``memsys.own_patches`` is a cluster's memory, ``memsys.cache_policy`` that of its cache. Latencies and
        capacities.
    supply
        Levels of memory in front of main memory.
    """
    found, held, caches = [], None, None
    for step in steps:
        if held is None:
            held = [set() for _ in step.plan.sectors]
            caches = [_cache(config, supply) for _ in held]
        found.append(_simulate(step, timing, supply, held, caches))
        held = [memory.held for memory in found[-1].memories]
    return found


def _cache(config, supply):
    if supply is Supply.MAIN:
        return None
    return Cache.of(config.memsys, lines=config.memsys.own_patches >> (supply is Supply.PUSHED))


def _simulate(step, timing, supply, held, caches):
    agenda, plan, clusters = Agenda(), step.plan, len(held)
    levels, memories = clusters.bit_length() - 1, []
    host = PatchHost(agenda, timing, levels=levels, accept=lambda cluster, patch: memories[cluster].accept(patch),
                     answer=lambda cluster, patch: memories[cluster].answer(patch))
    resident = [frozenset(own.tolist()) if supply is Supply.PUSHED else frozenset() for own in plan.resident]
    held = [own & chosen for own, chosen in zip(held, resident, strict=True)]
    tags, named, begin = plan.tags, None, 0
    if supply is not Supply.PULLED:
        named = _named(tags, clusters)
        begin = host.announce([tags.links(patch) for patch in np.flatnonzero(tags.sent).tolist()])
    lacking = {patch for own, chosen in zip(held, resident, strict=True) for patch in chosen - own}
    for patch in plan.found.tolist():
        if patch in lacking:
            host.push(patch, tags.destinations(patch).tolist(), tags.links(patch))
    made = []
    for cluster, section in enumerate(plan.partition.sections):
        memories.append(ClusterMemory(
            agenda, timing, named=named and named[cluster], resident=resident[cluster],
            held=held[cluster], cache=caches[cluster],
            request=lambda patch, cluster=cluster: host.request(cluster, patch)))
        made.append(PaperCluster(agenda, timing, memories[-1], works=[one.works[cluster] for one in step.frusta],
                                 rays=section.rays, begin=begin))
    end, tree, sums = agenda.run(), MergeTree(levels=levels), []
    for number, frustum in enumerate(step.frusta):
        streams = [_messages(part, one.counts.ends[number] + section.rays) for part, one, section in zip(
            frustum.sums, made, plan.partition.sections, strict=True)]
        merged, last = tree.merge(streams, [
            one.counts.ends[number] + section.rays + len(stream.patch)
            for stream, one, section in zip(streams, made, plan.partition.sections, strict=True)])
        sums.append(merged)
        end = max(end, last)
    return PaperStep(
        prepared=step, cycles=end, counts=tuple(one.counts for one in made), memories=tuple(memories),
        pushed=host.pushed, replies=host.replies, link_words=host.link_words, root_cycles=host.busy, sums=tuple(sums))


def _named(tags, clusters):
    """The patches whose tags name each cluster."""
    named = [set() for _ in range(clusters)]
    for patch in np.flatnonzero(tags.sent).tolist():
        for cluster in tags.destinations(patch).tolist():
            named[cluster].add(patch)
    return [frozenset(one) for one in named]


def _messages(sums, begin):
    """The messages of a cluster's collector: one a cycle, after it has read the rays."""
    order = np.argsort(sums.patch)
    return Messages(sums.patch[order], sums.sum[order], begin + 1 + np.arange(len(order)))
