"""Routing tables against the rules of `golden.engine.noc.routing.route`, node by node; distances and cycles are
searched here.

The hardware has golden's tables, so nothing else would notice a wrong entry that still delivers its packets.
"""

from collections import deque
from itertools import pairwise

import pytest

from golden.engine.noc.routing import classes_needed, route
from golden.engine.noc.topology import LOCAL, TOPOLOGIES, Topology

SIZES = [(1, 1), (2, 1), (1, 5), (3, 3), (4, 2), (4, 4), (5, 3), (8, 4)]
CASES = [(name, *size) for name in TOPOLOGIES for size in SIZES
         if name != "hypercube" or size not in ((1, 5), (3, 3), (5, 3))]


def neighbours(name, columns, rows):
    """Of each node the node behind each named port, by the definition of the topology."""
    size, ports = columns * rows, []
    for node in range(size):
        row, column = divmod(node, columns)
        to = {}
        if name == "hypercube":
            to = {f"bit_{bit}": node ^ 1 << bit for bit in range(size.bit_length() - 1)}
        elif name in ("ring", "illiac"):
            to = {"east": (node + 1) % size, "west": (node - 1) % size}
            if name == "illiac":
                to |= {"south": (node + columns) % size, "north": (node - columns) % size}
        else:
            steps = {"east": (1, 0), "west": (-1, 0), "south": (0, 1), "north": (0, -1)}
            for port, (right, down) in steps.items():
                x, y = column + right, row + down
                if name == "torus":
                    x, y = x % columns, y % rows
                if 0 <= x < columns and 0 <= y < rows:
                    to[port] = y * columns + x
        ports.append({port: target for port, target in to.items() if target != node})
    return ports


def distances(ports, start):
    """Links from a node to all others, breadth first."""
    found, queue = {start: 0}, deque([start])
    while queue:
        node = queue.popleft()
        for target in ports[node].values():
            if target not in found:
                found[target] = found[node] + 1
                queue.append(target)
    return found


def ring_step(node, apart, size, is_odd):
    """1 or -1: the shorter direction around a ring; of two equal ones forward to even nodes."""
    apart %= size
    return 1 if 2 * apart < size or (2 * apart == size and not is_odd) else -1


def expected_port(name, columns, rows, node, destination):
    """The name of the output port by the rule; None where the rule of an Illiac network searches."""
    odd = (destination % columns + destination // columns) % 2 == 1
    if name == "hypercube":
        differ = node ^ destination
        return f"bit_{(differ & -differ).bit_length() - 1}"
    if name == "ring":
        odd = destination % 2 == 1 if rows == 1 else odd
        return "east" if ring_step(node, destination - node, columns * rows, odd) > 0 else "west"
    if name == "illiac":
        return None
    for size, apart, ports in ((columns, destination % columns - node % columns, ("east", "west")),
                               (rows, destination // columns - node // columns, ("south", "north"))):
        if apart:
            forward = apart > 0 if name == "mesh" else ring_step(node, apart, size, odd) > 0
            return ports[0] if forward or (name == "torus" and size == 2) else ports[1]
    return "local"


@pytest.mark.parametrize(("name", "columns", "rows"), CASES)
def test_every_entry_is_the_port_of_the_rule_on_a_shortest_path(name, columns, rows):
    topology = Topology(name, columns, rows)
    routing, ports = route(topology, classes_needed(topology)), neighbours(name, columns, rows)
    for source in range(topology.nodes):
        away = distances(ports, source)
        for destination in range(topology.nodes):
            path = routing.path(source, destination)
            assert len(path) == away[destination]
            node = source
            for at, output, _ in path:
                port = topology.ports[output]
                assert at == node
                expected = expected_port(name, columns, rows, node, destination)
                # Two nodes of a ring of two have one pair of links, whichever port it is.
                assert expected in (None, port) or ports[node].get(expected) == ports[node].get(port)
                node = ports[node][port]
            assert node == destination
            if name == "illiac":
                names = [topology.ports[output] for _, output, _ in path]
                down = [port in ("south", "north") for port in names]
                assert down == sorted(down), "steps from row to row are last"
                assert sum(down) == fewest_rows(topology.nodes, columns, source, destination, len(path))
        assert routing.hops[source].tolist() == [away[destination] for destination in range(topology.nodes)]
    assert (routing.port.diagonal() == LOCAL).all()
    assert (routing.channel.diagonal() == 0).all()


def fewest_rows(nodes, columns, source, destination, length):
    """The fewest steps from row to row of all paths of that many steps."""
    return min(abs(down) for down in range(-length, length + 1) for along in (abs(down) - length, length - abs(down))
               if (destination - source - down * columns - along) % nodes == 0)


def channel_waits(topology, routing):
    """For each channel of a link the channels that packets on it request next."""
    waits = {}
    for source in range(topology.nodes):
        for destination in range(topology.nodes):
            path = routing.path(source, destination)
            for held in path:
                waits.setdefault(held, set())
            for held, requested in pairwise(path):
                waits[held].add(requested)
    return waits


@pytest.mark.parametrize(("name", "columns", "rows"), CASES)
def test_channels_can_be_removed_one_by_one_until_none_waits(name, columns, rows):
    topology = Topology(name, columns, rows)
    for channels in (count for count in (1, 2, 4) if count % classes_needed(topology) == 0):
        routing = route(topology, channels)
        waits = channel_waits(topology, routing)
        assert {held[:2] for held in waits} == {(link.source, link.output) for link in topology.links}
        assert all(0 <= channel < channels for _, _, channel in waits)
        assert 0 <= routing.entry.min() <= routing.entry.max() < channels
        # Without a cycle there is always a channel whose packets wait for no other.
        while waits:
            free = {held for held, requested in waits.items() if not requested}
            assert free, "these wait for each other in a cycle"
            waits = {held: requested - free for held, requested in waits.items() if held not in free}


@pytest.mark.parametrize(("name", "columns", "rows"), [
    ("torus", 4, 4), ("torus", 8, 4), ("torus", 5, 3), ("ring", 8, 1)])
def test_classes_are_those_of_the_dateline(name, columns, rows):
    topology = Topology(name, columns, rows)
    routing = route(topology, 2)
    assert classes_needed(topology) == 2
    after, crossing = set(), {}
    for source in range(topology.nodes):
        for destination in range(topology.nodes):
            crossed = None
            for node, output, channel in routing.path(source, destination):
                port = topology.ports[output]
                size = columns if port in ("east", "west") else rows
                here = node % columns if port in ("east", "west") else node // columns
                end = destination % columns if port in ("east", "west") else destination // columns
                if crossed != port and (here, port) in (
                        (size - 1, "east"), (0, "west"), (size - 1, "south"), (0, "north")):
                    crossed = port
                will = end < here if port in ("east", "south") else end > here
                crossing[node, destination] = (0 if will else end % 2, channel, size)
                if crossed == port:
                    after.add((node, destination))
    for where, (before, channel, _) in crossing.items():
        assert channel == (1 if where in after else before), where
