"""Distributor: the tree of switches between the host and the clusters."""

from golden.base.errors import check_int

__all__ = ["Distributor"]


class Distributor:
    """The times at which packets arrive at clusters, and the traffic of the tree.

    All links are equally wide, and all packets come from the root. So a packet waits there alone: below it no link has
    more traffic than the root's. Switches forward it word by word (cut-through).

    Parameters
    ----------
    levels
        Levels of switches, at least 0: 2^levels clusters.
    switch
        Cycles from a word at a switch's input to its output.

    Members
    -------
    root_words, link_words
        Counts: words that have left the root, each a cycle; and words over all links.
    free
        The cycle from which the root can send the next packet.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below its least.
    """

    def __init__(self, *, levels: int, switch: int):
        check_int("Levels", levels, least=0)
        check_int("Switch", switch, least=0)
        self._delay = levels * switch
        self.root_words = self.link_words = self.free = 0

    def send(self, time: int, links: int, *, words: int) -> int:
        """Send a packet that the host offers at ``time`` over ``links`` links: the cycle of its last word at clusters.

        All clusters that receive it have it in the same cycle.
        """
        begin = max(time, self.free)
        self.free = begin + words
        self.root_words += words
        self.link_words += words * links
        return self.free + self._delay
