"""The completion record: what the machine reports of a descriptor, in a ring of its own."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.memory_map.layout import Field, Region

__all__ = ["COMPLETION", "NO_CLUSTER", "lap", "parse_completions", "patch_sources"]

_LAP_BITS = 16
# The field `cluster` of a record if no cluster has cast the descriptor.
NO_CLUSTER = 0xFF
COMPLETION = Region("completion", "job", "entry of the ring", "What became of a descriptor. It is written when all "
                    "writes of results have been answered; its last word comes last.", (
    Field("address", "u8", "the address or number concerned by the error"),
    Field("sums", "u4", "words of sums written"),
    Field("cycles", "u4", "cycles of the cast"),
    Field("begin", "u4", "the machine's cycle counter when the cast or the load began"),
    Field("end", "u4", "the same when the last write of a result was answered, or the load ended"),
    Field("tested", "u4", "counter `intersection_tested` of the cast"),
    Field("visited", "u4", "counter `intersection_visited`"),
    Field("steps", "u4", "counter `traversal_steps`"),
    Field("found", "u4", "counter `memory_found`: patches of the next four fields and of the patch store"),
    Field("own", "u4", "patches read from the cluster's own memory"),
    Field("remote", "u4", "patches from other clusters"),
    Field("hits", "u4", "patches from the cache that all clusters share"),
    Field("misses", "u4", "patches from main memory"),
    Field("tag", "u4", "that of the descriptor"),
    Field("error", "u1", "error code, 0: none"),
    Field("cluster", "u1", f"the cluster that has cast it, {NO_CLUSTER:#x}: none"),
    Field("lap", "u2", "completions before this one, divided by the entries of the ring, plus 1, modulo 2^16"),
))


def lap(number: int, ring_bits: int) -> int:
    """The lap of completion ``number``, which has so many before it, in a ring of 2^``ring_bits`` entries.

    A completion has arrived when its entry has its lap: a host reads completions in their order, so until then the
    entry has the lap before. Laps of the first ring are 1: the ring must be 0 before.
    """
    return ((number >> ring_bits) + 1) % (1 << _LAP_BITS)


def parse_completions(data: bytes) -> np.ndarray:
    """The completion records in ``data``, one after the other. ``tobytes()`` of the result is ``data``.

    Raises
    ------
    InputError
        ``data`` is no whole number of records.
    """
    size = COMPLETION.dtype.itemsize
    if len(data) % size:
        raise InputError(f"completions: Bytes must be a multiple of {size}, not {len(data)}")
    return np.frombuffer(data, dtype=COMPLETION.dtype)


def patch_sources(records: np.ndarray) -> dict[str, np.ndarray]:
    """Patches of each section by source: ``own``, ``kept``, ``remote``, ``hits``, ``misses``.

    The patch store's, ``kept``, are those found that have no other source. So the numbers are those of sections without
    an error.

    Parameters
    ----------
    records
        N records of `COMPLETION`.

    Returns
    -------
    dict
        N int64 for each source.
    """
    own, remote, hits, misses, found = (
        records[name].astype(np.int64) for name in ("own", "remote", "hits", "misses", "found"))
    return {"own": own, "kept": found - own - remote - hits - misses, "remote": remote, "hits": hits, "misses": misses}
