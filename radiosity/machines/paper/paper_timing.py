"""Timing of the paper's machine: latencies and capacities that the paper does not state."""

from dataclasses import dataclass
from typing import ClassVar

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["PaperTiming"]


@dataclass(frozen=True, kw_only=True)
class PaperTiming(TimingNumbers):
    """Numbers in cycles unless stated otherwise.

    `radiosity.machines.paper.paper_latencies.paper_timing` takes them from the engine's components of the same
    function.

    Parameters
    ----------
    traversal
        From a grid ray to its first cell.
    resident, cache
        From a reference to a patch to its first vertex, in the resident set and of a cache hit.
    vertices, setup
        Of a patch in the intersection unit: between two of them, and from its last vertex to its window.
    pipeline
        From a test to its result.
    words, switch
        Of a patch on a link of the tree of switches; and of a switch.
    main
        Of main memory, from a request to the first word.
    requests
        Patches that a cluster may have requested and not received, at most.
    deferred
        Rays, each with its patch, that the deferred-ray memory of a cluster holds.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below 0, or words, vertices or requests are below 1.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("vertices", "words", "requests")

    traversal: int
    resident: int
    cache: int
    vertices: int
    setup: int
    pipeline: int
    words: int
    switch: int
    main: int
    requests: int
    deferred: int
