"""Columns of the arrays of a torus, by what a row of each array is of."""

from radiosity.machines.common.columns import columns

__all__ = ["Child", "Count", "Grid", "Item", "Link", "Node", "Packet", "Ray", "Reference", "Tally", "Walk"]

Packet = columns("Packet", "STATE LAST_BUSY")
"""The state packet: the phase that it announces, and the node that was the last one to be busy."""

Node = columns("Node", "PHASE IS_INACTIVE HAS_PACKET RAYS SHADOWS OBJECTS OBJECTS_LAST OUT OUT_LAST SLEEPS "
               "BLOCKED_LINK PRIMARY PRIMARY_END REQUESTED HELD")
"""A node: its phase, whether it has done no work since the packet's last visit, whether it has it; the first item of
each queue, and behind it the last one; whether it sleeps; the link that it waits for; the primary rays that it has not
begun; the links by which it has requested rows; rays that it holds."""

Item = columns("Item", "NEXT KIND PIXEL LEVEL MEDIUM HOPS VIA TARGET COLUMN")
"""A ray or message: the item behind it, its kind, its pixel, object, packet or row; of a ray its ancestors, medium and
hand-overs; the link that it leaves by; its destination or end column; its first column."""

Link = columns("Link", "FIRST LAST ARRIVED USED LATEST MESSAGES")
"""A link, one each way: its messages, those that have arrived, bytes in its buffer, the last arrival, and all
messages."""

Tally = columns("Tally", "PRIMARIES MADE SHADOWS_MADE TRACED PASSED PACKETS VALUES GIVEN CALLS MOST_HELD DOWNLOADED")
"""What a node counts: primary rays; rays and shadow rays made; walks; hand-overs; packets and values sent; rows given
away; calls; most rays held; objects downloaded."""

Count = columns("Count", "LIVE FREE_ITEMS FREE_PACKETS WALKS SENT LOGGED ENDED")
"""The machine: messages, rays and objects in it but for the state packet; free items and packets; walks; messages;
walks in the log; nodes at the end."""

Walk = columns("Walk", "STEPS SPHERE_TESTS POLYGON_TESTS SPHERE_HITS POLYGON_HITS CHAINED")
"""A walk: voxel steps, tests and hits of objects, entries of chains that were compared."""

Ray = columns("Ray", "DIRECTION ORIGIN COLOUR CONTRIBUTION ENTRY LIMIT END", (0, 3, 6, 9, 12, 13, 14))
"""A ray's numbers, three of each of the first four. A shadow ray's limit is the distance of its light."""

Child = columns("Child", "LEVEL MEDIUM IS_SHADOW")
"""Integers of a ray that a hit spawns. The medium is an object, or -1 for air."""

Grid = columns("Grid", "SUBDIVISIONS TABLE BITS ENTRIES")
"""A node's voxels: v, where its table and bits begin, and heads of its hash table or 0 of an array."""

Reference = columns("Reference", "OBJECT NEXT TAG")
"""An entry of a voxel's list: an object, the next entry, and the voxel."""
