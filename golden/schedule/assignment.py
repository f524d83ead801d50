"""Assignment: which processor of a network becomes which cluster."""

import numpy as np

from golden.icu.window import Window
from golden.schedule.classification import rays_inside
from golden.schedule.sections import Partition

__all__ = ["heaviest_to_nearest", "mean_hops", "simple", "traffic"]


def traffic(partition: Partition, window: Window, cluster: np.ndarray) -> np.ndarray:
    """Patches that pass between clusters in one frustum.

    Parameters
    ----------
    window
        Of the patches found, in the dense frustum.
    cluster
        Where each is at home (`classify`); every other cluster into whose section its window reaches fetches it once.

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


def simple(clusters: int) -> np.ndarray:
    """Cluster i is processor i: N int64.

    Source: Shen 1993, section 4.4.2.3.
    """
    return np.arange(clusters)


def heaviest_to_nearest(load: np.ndarray, hops: np.ndarray) -> np.ndarray:
    """The processor of each cluster: heavy traffic goes short ways.

    Begins with the cluster of most traffic on the processor of most links. Then, again and again, takes the heaviest
    pair of a cluster that has a processor and one that has not, and puts the latter as near to the former as can be.
    Clusters without traffic to any placed one begin anew. Of equals the smaller number is taken.

    Parameters
    ----------
    load
        N x N of at least 0, symmetric, 0 on the diagonal (`traffic`).
    hops
        N x N, links between processors (`golden.noc.topology.Topology`).

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
        placed = processor >= 0
        between = np.where(~placed[:, None] & placed, load, -1)
        if between.max() > 0:
            cluster, partner = np.unravel_index(np.argmax(between), between.shape)
            away = hops[processor[partner]]
            chosen = np.argmin(np.where(free, away, away.max() + 1))
        else:
            cluster = np.argmax(np.where(placed, -1, load.sum(axis=1)))
            chosen = np.argmax(np.where(free, links, -1))
        processor[cluster] = chosen
        free[chosen] = False
    return processor


def mean_hops(load: np.ndarray, hops: np.ndarray, processor: np.ndarray) -> float:
    """Links that a patch passes between its cluster and another's, on average; 0 without traffic."""
    load = np.asarray(load)
    return float((load * np.asarray(hops)[np.ix_(processor, processor)]).sum() / max(1, load.sum()))
