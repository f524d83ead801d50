"""Reference strings: the requests of the clusters to a shared cache, frustum after frustum."""

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord

__all__ = ["ReferenceStrings", "interleaved"]


@dataclass(frozen=True, kw_only=True)
class ReferenceStrings:
    """The requests of each frustum and cluster: ``cells[frustum][cluster]``, and likewise patches.

    Parameters
    ----------
    cells, patches
        Arrays of int64 numbers in the order of the requests.
    """

    cells: tuple[tuple[np.ndarray, ...], ...]
    patches: tuple[tuple[np.ndarray, ...], ...]

    @classmethod
    def of(cls, shelling: Shelling, records: list[FrustumRecord], sectors: tuple = (),
           subshells: tuple = ()) -> "ReferenceStrings":
        """The requests of a sequence of casts.

        Parameters
        ----------
        records
            The frusta.
        sectors, subshells
            Parts of the frustum per cluster, and their subshells, see `Shelling.cast`.
        """
        frusta = []
        for record in records:
            memory = shelling.memory(record)
            tests, parts = shelling.tests(record, memory), sectors or (Sector.whole(record),)
            frusta.append([list(shelling.stages(record, sector, listed, tests, memory, ShellingCounts()))
                           for sector, listed in zip(parts, subshells or [None] * len(parts), strict=True)])
        none = np.zeros(0, dtype=np.int64)
        return cls(**{name: tuple(tuple(np.concatenate([none, *(getattr(stage, part) for stage in stages)])
                                        for stages in frustum) for frustum in frusta)
                      for name, part in (("cells", "opened"), ("patches", "found"))})


def interleaved(frusta, *, resident=None) -> np.ndarray:
    """One string of all clusters in round-robin order; a frustum begins when all clusters have finished the one before.

    Parameters
    ----------
    frusta
        ``cells`` or ``patches`` of a `ReferenceStrings`.
    resident
        Per number: it is in a resident set, so the cache receives no request for it. Default: none is.
    """
    numbers = [number for clusters in frusta for one in zip_longest(*(cluster.tolist() for cluster in clusters))
             for number in one if number is not None]
    string = np.array(numbers, dtype=np.int64)
    return string if resident is None else string[~np.asarray(resident, dtype=bool)[string]]
