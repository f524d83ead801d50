"""Cluster timing: latencies and capacities of a cluster's components, as their docstrings state them."""

from dataclasses import dataclass
from typing import ClassVar

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["ClusterTiming"]


@dataclass(frozen=True, kw_only=True)
class ClusterTiming(TimingNumbers):
    """Numbers of a cluster that the golden model does not know, in cycles unless stated otherwise.

    `radiosity.machines.engine.cluster_latencies.cluster_timing` takes them from the components of a configuration.

    Parameters
    ----------
    begin
        From the begin of a section to its first near cell.
    listing
        By which a shadow frustum begins later, without a cycle for each ray of its list.
    generator
        From the permission of a stage to its first request, without the searches of rows and columns.
    search
        Of a search of rows or columns, for each bit of their number.
    row, piece, arc
        Of a row of grid rays, of each of its arcs, and of a search for the ends of an arc without ``search``.
    traversal
        From a request to its first cell.
    sweep
        From the read of a tile of settle codes to the square that survival reads.
    memory
        From a cell to the first vertex of its first patch.
    vertices
        Vertices of a patch, one in each cycle.
    setup
        From a patch's last vertex to its window.
    walk
        From a window to its first ray.
    pipeline
        From a ray to its end.
    over
        From the end of a stage's last item to the end of the stage.
    end
        From the end of the last stage or patch to the end of the cast.
    cells, lists, entries, requests, waiting
        Capacities between traversal and the cell filter, from there to the lists, between these and the patch filter,
        from there to the patches' geometry, and from there to the slots; items.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is negative, or a capacity or the number of vertices below 1.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("vertices", "cells", "lists", "entries", "requests", "waiting")

    begin: int
    listing: int
    generator: int
    search: int
    row: int
    piece: int
    arc: int
    traversal: int
    sweep: int
    memory: int
    vertices: int
    setup: int
    walk: int
    pipeline: int
    over: int
    end: int
    cells: int
    lists: int
    entries: int
    requests: int
    waiting: int
