"""Page timing: what a fault, a server, a message and a reference take."""

from dataclasses import dataclass

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["PageTiming"]


@dataclass(frozen=True, kw_only=True)
class PageTiming(TimingNumbers):
    """Nanoseconds of the shared memory's steps.

    The source has none of them. The times of messages are the iPSC/2's, as in `NodeTiming`. A fault takes ``trap`` and
    a message's handling ``serve``; both are one number, fitted on the source's times of Teapot in table 4 alone.

    Parameters
    ----------
    setup, word
        ns to set a message up, and of each of its words of 4 bytes on a link.
    trap
        ns of the fault itself, before its request.
    serve
        ns to handle a message at interrupt level.
    access
        ns of each reference to a page of another home: 0 with an MMU, more where the program itself checks.
    is_offloaded
        1 if a device beside the processor handles messages, else 0: the node's program is interrupted.

    Raises
    ------
    TypeError, ValueError
        See `TimingNumbers`.

    Source: Badouel 1991, sections 3 and 4; section 6 for the device.
    """

    setup: int = 400_000
    word: int = 1430
    trap: int = 1_000_000
    serve: int = 1_000_000
    access: int = 0
    is_offloaded: int = 0
