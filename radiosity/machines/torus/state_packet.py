"""State packet: the token whose laps show that all nodes are idle, and which moves them from phase to phase.

A node is idle if it has no work and all that it sent has been taken by its neighbours. Handling of the packet is no
work. In the source, a message that has been sent is in the receiver's buffer, and none is in flight. Its printed code
does not adopt a phase while it is active; here an active node does, since a phase only begins when all nodes were idle.

Source: Pearce 1987, chapter 3, algorithm 3-2; in the figure, marks of statements are garbled.
"""

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.columns import Node, Packet

__all__ = ["CLIPPING", "END", "FLUSHPIX", "PHASES", "RAYTRACE", "enter_phase", "receive_packet", "release_packet"]

CLIPPING, RAYTRACE, FLUSHPIX, END = range(4)
PHASES = ("clipping", "ray-trace", "flush", "end")


@compiled
def receive_packet(packet: np.ndarray, nodes: np.ndarray, node: int, is_idle: bool) -> None:
    """The packet arrives. An inactive node is to send it on; an active one keeps it until it is idle.

    Parameters
    ----------
    packet
        2 int64, see `Packet`.
    nodes
        P rows of int64, see `Node`.
    node
        Who receives.
    is_idle
        Whether it is idle now.
    """
    state = nodes[node]
    if state[Node.IS_INACTIVE] and is_idle:
        if packet[Packet.LAST_BUSY] == node:
            packet[Packet.STATE] += 1
        if state[Node.PHASE] != packet[Packet.STATE]:
            packet[Packet.LAST_BUSY] = node
        state[Node.PHASE] = packet[Packet.STATE]
        state[Node.HAS_PACKET] = 0
    else:
        packet[Packet.LAST_BUSY] = node
        enter_phase(nodes, node, packet[Packet.STATE])
        state[Node.IS_INACTIVE] = state[Node.HAS_PACKET] = 1


@compiled
def release_packet(packet: np.ndarray, nodes: np.ndarray, node: int) -> None:
    """A node that has kept the packet is idle: it signs and is to send it on."""
    packet[Packet.LAST_BUSY] = node
    nodes[node, Node.IS_INACTIVE], nodes[node, Node.HAS_PACKET] = 1, 0


@compiled
def enter_phase(nodes: np.ndarray, node: int, phase: int) -> None:
    """A node has seen a later phase, by the packet or by a message that only a node in that phase sends."""
    nodes[node, Node.PHASE] = max(nodes[node, Node.PHASE], phase)
