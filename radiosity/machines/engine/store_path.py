"""Store path: which patches of others a cluster's patch store has, and what its path adds to their cycles."""

from dataclasses import dataclass

import numpy as np

from golden.engine.memsys.patches.patch_store import PatchStore
from radiosity.machines.common.timing_numbers import PositiveNumbers
from radiosity.machines.engine.cluster_cast import KEPT

__all__ = ["StoreTiming", "ask_store", "store_after"]


@dataclass(frozen=True, kw_only=True)
class StoreTiming(PositiveNumbers):
    """Numbers of the path through a patch store, in cycles unless stated otherwise.

    `radiosity.machines.engine.job_latencies.store_timing` takes them from the components of a configuration.

    Parameters
    ----------
    lookup
        From a request to its fetch, and to the next request.
    kept
        From a request to the cycle in which the patch can be read like an own one, of a patch that is kept.
    passed, stored
        By which a patch that is fetched comes later than without a store: not kept, and kept from now on.
    vertices
        For which a patch that leaves its frame occupies the memory of the frames.
    waiting
        Patches that may wait in front of the store.
    requests
        Requests in flight, at most.

    Raises
    ------
    TypeError, ValueError
        See `PositiveNumbers`.
    """

    lookup: int
    kept: int
    passed: int
    stored: int
    vertices: int
    waiting: int
    requests: int


def ask_store(store: PatchStore, patches: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Request the patches of a section from a store.

    Parameters
    ----------
    store
        As the casts before have left it; it changes.
    patches
        P int64: the patches in the order of discovery.
    owner
        P int64: the cluster that holds each, -1 of own ones, which are not requested.

    Returns
    -------
    owner, is_stored
        P int64: the same, `KEPT` where the store has the patch. P bool: it keeps the patch that is fetched.
    """
    owner, is_stored = owner.copy(), np.zeros(len(patches), dtype=bool)
    for place in np.flatnonzero(owner != -1):
        patch = int(patches[place])
        if store.request(patch):
            owner[place] = KEPT
        else:
            is_stored[place] = patch in store
    return owner, is_stored


def store_after(frames: int, patches: np.ndarray) -> tuple[PatchStore, np.ndarray]:
    """A store after requests.

    Parameters
    ----------
    frames
        Patches that it keeps.
    patches
        P int64: what has been requested, in order.

    Returns
    -------
    store, fetched
        The store. F int64: those of the patches that were fetched, in order.
    """
    store = PatchStore(frames)
    return store, np.array([patch for patch in patches.tolist() if not store.request(patch)], dtype=np.int64)
