"""The five parts of the machine: which of them a configuration has, and why."""

from dataclasses import dataclass

from golden.base.plural import counted
from golden.engine.config.config import Config

__all__ = ["Part", "parts"]


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of the machine.

    Parameters
    ----------
    name
        Its name.
    size
        How much of it a configuration has; empty if there is none.
    about
        What it is for, and the parameters that decide; or why there is none.
    """

    name: str
    size: str
    about: str


def parts(config: Config) -> tuple[Part, ...]:
    """Cell traversal, intersection pipeline, resident set and caches, I-structure, router: in this order.

    Parameters
    ----------
    config
        The configuration.
    """
    clusters, memsys = config.noc.clusters, config.memsys
    each, each_node = _times(clusters), _times(config.noc.nodes)
    pipelines = config.ctu.traversal_pipelines(clusters)
    return (
        Part(name="cell traversal", size=f"{each}{pipelines} pipeline{'s' if pipelines > 1 else ''}",
             about="finds the cells that grid rays meet, one per cycle and pipeline (ctu.pipelines)"),
        Part(name="intersection pipeline", size=f"{each}{config.icu.rays} rays",
             about="tests a ray against a patch in each cycle, and has memory for so many rays (icu.rays)"),
        Part(name="resident set and caches", size=f"{each_node}{memsys.own_patches} patches, caches of "
             f"{memsys.cell_lines} and {memsys.patch_lines} lines",
             about="a node's own patches (memsys.own_patches); in front of main memory the caches of all clusters, of "
             "cells and of patches (memsys.cell_lines, memsys.patch_lines)"),
        _istructure(config, each),
        _router(config))


def _times(count):
    return "" if count == 1 else f"{count} x "


def _istructure(config, each):
    memsys, structures = config.memsys, []
    if memsys.store_patches:
        structures.append((
            f"store of {memsys.store_patches} patches, {memsys.store_requests} requests",
            "requests for patches outside the resident set wait in the patch store for one fetch "
            "(memsys.store_patches, memsys.store_requests)"))
    if config.ctu.subshells:
        structures.append((
            f"{config.ctu.ray_slots} grid rays",
            "a request for a grid ray that is absent waits until it returns: there are lists of subshells "
            "(ctu.subshell_bits, ctu.ray_slots)"))
    if not structures:
        return Part(name="I-structure", size="", about="there is no patch store (memsys.store_patches=0)")
    return Part(name="I-structure", size=" and ".join(f"{each}{size}" for size, _ in structures),
                about="; ".join(about for _, about in structures))


def _router(config):
    noc = config.noc
    if noc.nodes == 1:
        return Part(name="router", size="", about="a single cluster requests no patches of another one "
                    "(noc.columns=1, noc.rows=1)")
    return Part(name="router", size=f"{noc.nodes * (2 if noc.networks == 'physical' else 1)} in {noc.network()}",
                about=f"requests for patches from {_ends(noc)}, and the replies: a router for each node and "
                "network (noc.columns, noc.rows, noc.topology, noc.networks)")


def _ends(noc):
    """Which nodes send requests, and which serve them."""
    if noc.patch_nodes == 0:
        return "cluster to cluster"
    patch_nodes = f"{counted(noc.patch_nodes, 'patch node')} (noc.patch_nodes)"
    return f"the cluster to {patch_nodes}" if noc.clusters == 1 else f"cluster to cluster and to {patch_nodes}"
