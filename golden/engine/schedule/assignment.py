"""Assignment of clusters to the processors of a network."""

import numpy as np

from golden.engine.icu.window import Window
from golden.engine.schedule.classification import rays_inside
from golden.engine.schedule.sections import Partition

__all__ = ["heaviest_to_nearest", "mean_hops", "traffic"]


def traffic(partition: Partition, window: Window, cluster: np.ndarray) -> np.ndarray:
    """Patches that pass between clusters in one frustum.

    Parameters
    ----------
    window
        Windows of the patches found, in the dense frustum.
    cluster
        Home of each patch (`classify`); every other cluster whose section meets its window fetches it once.

    Returns
    -------
    N x N int64, symmetric, both directions together; 0 on the diagonal.
    """
    clusters = len(partition.sections)
    fetched = np.zeros((clusters, clusters), dtype=np.int64)
    for number, part in enumerate(partition.levels[-1]):
        reached = rays_inside(window, part, partition.columns) > 0
        fetched[number] = np.bincount(cluster[reached], minlength=clusters)
    np.fill_diagonal(fetched, 0)
    return fetched + fetched.T


def heaviest_to_nearest(load: np.ndarray, hops: np.ndarray) -> np.ndarray:
    """The processor of each cluster, such that heavy traffic has short routes.

    The cluster of most traffic is assigned to the processor of most links. Then, repeatedly, the heaviest pair of an
    assigned and an unassigned cluster is chosen, and the latter assigned to the free processor nearest to the former.
    Clusters without traffic to an assigned one start anew. The smaller number of equals is chosen.

    Parameters
    ----------
    load
        N x N of at least 0, symmetric, 0 on the diagonal (`traffic`).
    hops
        N x N, links between processors (`golden.engine.noc.topology.Topology`).

    Returns
    -------
    N int64, a permutation.

    Source: Shen 1993, Fig. 4.12.
    """
    load, hops = np.asarray(load), np.asarray(hops)
    count = len(load)
    processor = np.full(count, -1, dtype=np.int64)
    free = np.ones(count, dtype=bool)
    links = (hops == 1).sum(axis=1)
    for _ in range(count):
        assigned = processor >= 0
        between = np.where(~assigned[:, None] & assigned, load, -1)
        if between.max() > 0:
            cluster, partner = np.unravel_index(np.argmax(between), between.shape)
            away = hops[processor[partner]]
            chosen = np.argmin(np.where(free, away, away.max() + 1))
        else:
            cluster = np.argmax(np.where(assigned, -1, load.sum(axis=1)))
            chosen = np.argmax(np.where(free, links, -1))
        processor[cluster] = chosen
        free[chosen] = False
    return processor


def mean_hops(load: np.ndarray, hops: np.ndarray, processor: np.ndarray) -> float:
    """Links that a patch passes between its cluster and another's, on average; 0 without traffic."""
    load = np.asarray(load)
    return float((load * np.asarray(hops)[np.ix_(processor, processor)]).sum() / max(1, load.sum()))
