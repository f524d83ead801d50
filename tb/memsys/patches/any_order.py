"""What an I-structure answers in one version, whatever the order of its accesses."""

import numpy as np

__all__ = ["answers"]


def answers(reads: np.ndarray, writes: np.ndarray, data: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Results of the accesses of one version, for any order of reads and writes.

    Parameters
    ----------
    reads
        Addresses of the reads.
    writes, data
        Addresses and data of the writes in their order: of several to one location the first counts.

    Returns
    -------
    tuple
        Per read whether its location is written, and the data (0 where it is not); per write whether it is refused.
    """
    written, first = np.unique(writes, return_index=True)
    refused = np.ones(len(writes), dtype=bool)
    refused[first] = False
    if not len(written):
        return np.zeros(len(reads), dtype=bool), np.zeros(len(reads), dtype=np.int64), refused
    found = np.minimum(np.searchsorted(written, reads), len(written) - 1)
    answered = written[found] == reads
    return answered, np.where(answered, np.asarray(data)[first[found]], 0), refused
