"""One of the machine's parts, as a configuration has it."""

from dataclasses import dataclass

__all__ = ["Part"]


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of the machine.

    Parameters
    ----------
    name
        Its name.
    size
        How much of it a configuration has; empty if there is none.
    about
        What it is for, and the parameters that decide; or why there is none.
    """

    name: str
    size: str
    about: str
