"""Pixel exchange: nodes send pixels of regions, and merge what they receive with what they have there."""

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.merge.exchange_steps import ExchangeSteps
from radiosity.machines.merge.winning_pixels import Pixels, is_before

__all__ = ["SENT", "TOUCHED", "exchange", "received_by_owners", "scattered"]

SENT, TOUCHED, MET = range(3)
"""Columns of an exchange: pixels that a node sends; pixels of both lists that it merges; locations in both."""


def exchange(pixels: Pixels, steps: ExchangeSteps, step: int, bounds: np.ndarray) -> tuple[Pixels, np.ndarray]:
    """The pixels after a step, and P x 3 int64: what each node has sent, merged, and found at one location.

    Parameters
    ----------
    pixels
        What nodes hold.
    steps, step
        Who sends what, and the number of the step.
    bounds
        R + 1 int64: the first location of each region, and the one after the last.
    """
    nodes = len(pixels.start) - 1
    counts, start = np.zeros((nodes, 3), dtype=np.int64), np.zeros(nodes + 1, dtype=np.int64)
    location, depth, shade = (np.empty_like(each) for each in pixels[1:])
    _exchange(pixels.start, pixels.location, pixels.depth, pixels.shade, bounds[steps.first[step]],
              bounds[steps.last[step]], steps.source[step], start, location, depth, shade, counts)
    end = start[nodes]
    return Pixels(start, location[:end].copy(), depth[:end].copy(), shade[:end].copy()), counts


@compiled
def _exchange(held, location, depth, shade, first, last, source, start, new_location, new_depth, new_shade, counts):
    """Each node's own pixels without those that it sends, merged by location with those that come."""
    end = 0
    for node in range(len(source)):
        other = source[node]
        own, own_end = held[node], held[node + 1]
        taken = held[other] + np.searchsorted(location[held[other]:held[other + 1]], first[other])
        taken_end = held[other] + np.searchsorted(location[held[other]:held[other + 1]], last[other])
        while True:
            while own < own_end and first[node] <= location[own] < last[node]:
                own += 1
                counts[node, 0] += 1
            is_own = own < own_end and (taken == taken_end or location[own] <= location[taken])
            is_taken = taken < taken_end and (own == own_end or location[taken] <= location[own])
            if not is_own and not is_taken:
                break
            at = own
            if is_taken and (not is_own or is_before(depth[taken], shade[taken], depth[own], shade[own])):
                at = taken
            new_location[end], new_depth[end], new_shade[end] = location[at], depth[at], shade[at]
            end += 1
            if is_own and is_taken:
                counts[node, 2] += 1
            if is_own:
                counts[node, 1] += first[other] <= location[own] < last[other]
                own += 1
            if is_taken:
                counts[node, 1] += 1
                taken += 1
        start[node + 1] = end


def received_by_owners(pixels: Pixels, bounds: np.ndarray) -> np.ndarray:
    """P x R int64: the pixels of each node in each region."""
    found = [np.searchsorted(pixels.location[first:last], bounds) for first, last in zip(
        pixels.start[:-1], pixels.start[1:], strict=True)]
    return np.diff(np.array(found, dtype=np.int64).reshape(-1, len(bounds)), axis=1)


def scattered(pixels: Pixels, bounds: np.ndarray) -> Pixels:
    """The picture after an exchange from each to all, by a z-buffer in the owner of each region.

    An owner scatters its own pixels, then compares those of the other nodes in the order in which they come.

    Source: Kurc 1997, section 4.4.5.
    """
    order = np.lexsort((pixels.shade, pixels.depth, pixels.location))
    winners = order[np.flatnonzero(np.diff(pixels.location[order], prepend=-1))]
    location = pixels.location[winners]
    return Pixels(np.searchsorted(location, bounds), location, pixels.depth[winners], pixels.shade[winners])
