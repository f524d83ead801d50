"""Reference strings: what the clusters ask for, frustum after frustum, as a shared cache sees it."""

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from golden.cast.shelling import Shelling
from golden.frustum import FrustumRecord

__all__ = ["ReferenceStrings", "interleaved"]


@dataclass(frozen=True, kw_only=True)
class ReferenceStrings:
    """The requests of each frustum and cluster: ``cells[frustum][cluster]``, and likewise patches.

    Parameters
    ----------
    cells, patches
        Arrays of numbers, in the order in which they were asked for.
    """

    cells: tuple[tuple[np.ndarray, ...], ...]
    patches: tuple[tuple[np.ndarray, ...], ...]

    @classmethod
    def of(cls, shelling: Shelling, records: list[FrustumRecord], sectors: tuple = ()) -> "ReferenceStrings":
        """Of casts one after the other.

        Parameters
        ----------
        records
            The frusta.
        sectors
            The parts of the clusters, see `Shelling.cast`.
        """
        asked = []
        for record in records:
            requests = []
            shelling.cast(record, sectors, requests=requests)
            asked.append(requests)
        return cls(**{name: tuple(tuple(np.array(getattr(cluster, name), dtype=np.int64) for cluster in frustum)
                                  for frustum in asked) for name in ("cells", "patches")})


def interleaved(frusta, *, resident=None) -> np.ndarray:
    """One string of all clusters: each asks for one number in turn, and the next frustum begins when all have ended.

    Parameters
    ----------
    frusta
        ``cells`` or ``patches`` of a `ReferenceStrings`.
    resident
        Of each number whether it is held nearer than in the cache and never asked for here. Default: none is.
    """
    turns = [number for clusters in frusta for turn in zip_longest(*(cluster.tolist() for cluster in clusters))
             for number in turn if number is not None]
    string = np.array(turns, dtype=np.int64)
    return string if resident is None else string[~np.asarray(resident, dtype=bool)[string]]
