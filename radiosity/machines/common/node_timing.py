"""Timing of a node: its operations, its messages, and the operations of a hemicube."""

from dataclasses import dataclass
from typing import ClassVar

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["NodeTiming"]


@dataclass(frozen=True, kw_only=True)
class NodeTiming(TimingNumbers):
    """Nanoseconds of an operation and of messages, and operations of the steps of a form factor row.

    The defaults are the iPSC/2's: 5.87 us for an addition or multiplication and 400 us to set a message up, as the
    source has them; 1.43 us for a word of 4 bytes at its 2.8 MB/s. It has no operations of a hemicube. Ours are those
    of its steps: the side of a plane (3 subtractions, 3 multiplications, 2 additions); the height of 4 corners (8
    each); 4 corners moved and rotated (60) and compared with 5 planes of each of 5 faces (100); 4 edges clipped at 4
    planes (8 each), 4 corners divided (2 each) and 4 edges prepared for their scan (10 each); a depth, its comparison
    and two stores for a square; two stores to clear a square, and an addition and a store to sum it.

    Parameters
    ----------
    operation
        ns of an addition, a multiplication or an absolute value.
    setup, word
        ns to set a message up, and of each of its words on a link.
    visibility
        Operations to find that a patch does not face the hemicube.
    horizon
        Further operations on a patch that does, to find whether it is above the horizon.
    clipping
        Further operations on a patch that is, to find the faces that it meets.
    projection
        Further operations on each of these faces, until its squares are known.
    square
        Operations on a square that it covers.
    clearing, summing
        Operations on each square before and after all projections.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below 0, or an operation takes no time.

    Source: Kurc 1997, sections 2.3 and 2.7.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ("operation",)

    operation: int = 5870
    setup: int = 400_000
    word: int = 1430
    visibility: int = 8
    horizon: int = 32
    clipping: int = 160
    projection: int = 176
    square: int = 4
    clearing: int = 2
    summing: int = 2
