"""What is on the wires of a network's links in each cycle, as words that a testbench drives and compares."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from golden.engine.noc.network import NEVER, Arrivals, Packets

__all__ = ["LinkWords", "link_words"]

# Cycles after the last flit.
_AFTER = 8


@dataclass(kw_only=True, eq=False)
class LinkWords:
    """A word for each cycle: of each link ``valid``, the flit's data, ``first``, ``last``, its channel, and the credits
    that are returned beside it; the first link lowest.

    Parameters
    ----------
    bits, channels
        Of a flit's data; of a link.
    links, cycles
        How many.
    words
        The words.
    """

    bits: int
    channels: int
    links: int
    cycles: int
    words: list[int] = field(init=False)

    def __post_init__(self):
        self.words = [0] * self.cycles

    @property
    def payload_bits(self) -> int:
        """Of a link's payload: data, ``first``, ``last``, channel."""
        return self.bits + 2 + (self.channels - 1).bit_length()

    @property
    def link_bits(self) -> int:
        """Of a link in a word."""
        return 1 + self.payload_bits + self.channels

    def flit(self, cycle: int, link: int, data: int, first: bool, last: bool, channel: int) -> None:
        """A flit is on a link."""
        payload = data | int(first) << self.bits | int(last) << self.bits + 1 | channel << self.bits + 2
        self.words[cycle] |= (1 | payload << 1) << link * self.link_bits

    def credit(self, cycle: int, link: int, channel: int) -> None:
        """A credit is returned."""
        self.words[cycle] |= 1 << link * self.link_bits + 1 + self.payload_bits + channel


def link_words(packets: Packets, arrivals: Arrivals, data: Sequence[int], *, nodes: int, bits: int,
               channels: int) -> tuple[LinkWords, LinkWords]:
    """What a network is given, and what it must answer.

    Parameters
    ----------
    packets, arrivals
        A run of `Network` in which all flits were accepted.
    data
        Of each flit, those of a packet one after the other; a first one's lowest bits become its destination.
    nodes, bits, channels
        Of the network, of a flit's data, of a link.

    Raises
    ------
    ValueError
        A flit was not accepted.
    """
    if (arrivals.taken == NEVER).any():
        raise ValueError("Arrivals must be of a run in which all flits were accepted")
    of = arrivals.packet
    number = np.arange(len(of)) - (np.cumsum(packets.length) - packets.length)[of]
    given, required = (LinkWords(bits=bits, channels=channels, links=nodes, cycles=int(arrivals.taken.max()) + _AFTER)
                       for _ in range(2))
    address = max(1, (nodes - 1).bit_length())
    for flit, (packet, index) in enumerate(zip(of.tolist(), number.tolist(), strict=True)):
        first, last = index == 0, index == packets.length[packet] - 1
        source, destination = int(packets.source[packet]), int(packets.destination[packet])
        word = data[flit] >> address << address | destination if first else data[flit]
        given.flit(int(arrivals.entered[flit]), source, word, first, last, int(arrivals.entry[flit]))
        required.flit(int(arrivals.left[flit]), destination, word, first, last, int(arrivals.channel[flit]))
        given.credit(int(arrivals.taken[flit]), destination, int(arrivals.channel[flit]))
    for credit in arrivals.credits.tolist():
        required.credit(*credit)
    return given, required
