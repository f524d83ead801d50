"""A timing of small numbers, all of which differ."""

from dataclasses import replace

from radiosity.machines.paper.paper_timing import PaperTiming

__all__ = ["TIMING", "changed"]

TIMING = PaperTiming(traversal=7, resident=2, cache=5, vertices=4, setup=11, pipeline=13, words=6, switch=3, main=10,
                     requests=2, deferred=1000)


def changed(**numbers):
    """The timing with other numbers."""
    return replace(TIMING, **numbers)
