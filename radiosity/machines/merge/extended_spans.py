"""Extended spans: how many pixels win on each scanline, counted without drawing them."""

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.merge.span_lists import SpanLists

__all__ = ["extended_counts"]


def extended_counts(spans: SpanLists, nodes: int, height: int) -> np.ndarray:
    """P x H int64: locations that the spans of each node cover on each line.

    Spans that meet or touch become one. The printed algorithm keeps the last of these alone; ours adds them.

    Parameters
    ----------
    spans
        Sorted by node, line and first x.
    nodes, height
        P, and scanlines.

    Source: Kurc 1997, section 4.5.2, Fig. 4.2.
    """
    counts = np.zeros((nodes, height), dtype=np.int64)
    _count(spans.node, spans.line, spans.left, spans.right, counts)
    return counts


@compiled
def _count(node, line, left, right, counts):
    first, last = 0, -1
    for span in range(len(node)):
        if span == 0 or node[span] != node[span - 1] or line[span] != line[span - 1]:
            first, last = left[span], left[span] - 1
        if left[span] > last + 1:
            counts[node[span], line[span]] += last - first + 1
            first = left[span]
        last = max(last, right[span])
        if span + 1 == len(node) or node[span] != node[span + 1] or line[span] != line[span + 1]:
            counts[node[span], line[span]] += last - first + 1
