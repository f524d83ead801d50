"""Distributor: the tree of switches between the host and the clusters."""

from golden.errors import check_int

__all__ = ["Distributor"]


class Distributor:
    """The times at which patches arrive at clusters, and the traffic of the tree.

    All links are equally wide, and all patches come from the root. So a patch waits there alone: behind it no link has
    more traffic than the root's. Switches forward a patch word by word (cut-through).

    Parameters
    ----------
    levels
        Levels of switches, at least 0: 2^levels clusters.
    words
        Words of a patch, each a cycle on a link.
    switch
        Cycles from a word at a switch's input to its output.

    Members
    -------
    patches, link_words
        Counts: patches that have left the root, and words over all links.
    free
        The cycle from which the root can send the next patch.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below its least.
    """

    def __init__(self, *, levels: int, words: int, switch: int):
        for name, value, least in (("Levels", levels, 0), ("Words", words, 1), ("Switch", switch, 0)):
            check_int(name, value)
            if value < least:
                raise ValueError(f"{name} must be at least {least}, not {value!r}")
        self._words, self._delay = words, levels * switch + words
        self.patches = self.link_words = self.free = 0

    def send(self, time: int, links: int) -> int:
        """Send a patch that the host offers at ``time`` over ``links`` links: the cycle of its last word at clusters.

        All clusters that receive it have it in the same cycle.
        """
        begin = max(time, self.free)
        self.free = begin + self._words
        self.patches += 1
        self.link_words += self._words * links
        return begin + self._delay
