"""Patch network: a network interface for each cluster, and the networks between them."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.engine.config import Config
from hw.noc.network import Network
from hw.noc.network_interface import NetworkInterface, interface_members
from hw.noc.network_parameters import network_parameters

__all__ = ["PatchNetwork"]


class PatchNetwork(wiring.Component):
    """Requests for patches from each cluster to each other one, and the replies: two networks, or one with channels of
    its own for each kind.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_request, o_request : In, Out, a stream of ``node``, ``patch`` per cluster
        See `NetworkInterface`.
    i_reply : In, a stream of ``node``, ``vertex`` per cluster
        See `NetworkInterface`.
    o_reply : Out, a stream of `Formats.patch_vertex` per cluster
        See `NetworkInterface`.
    fault : Out, a `NetworkFault` per cluster
        See `NetworkInterface`.
    flits, stalls : Out(32)
        See `Network`; summed over both networks.

    Timing
    ------
    Latency: ``(router_cycles + 1) * (hops + 1) + 2`` cycles from ``i_request`` to ``o_request`` when nothing else is
    in flight.

    Raises
    ------
    InputError
        Channels could deadlock: the cycle is named.
    """

    def __init__(self, *, config: Config):
        self._config = config
        self._network = network_parameters(config)
        self._routing = self._network["routing"]
        nodes = self._routing.topology.nodes
        members = interface_members(config, nodes)
        super().__init__({**{name: member.array(nodes) for name, member in members.items()},
                          "flits": Out(32), "stalls": Out(32)})

    def elaborate(self, platform):
        m = Module()
        routing = self._routing
        networks = [Network(**self._network) for _ in range(2 if self._network["messages"] == 1 else 1)]
        for number, network in enumerate(networks):
            m.submodules[f"network_{number}"] = network
        m.d.comb += [self.flits.eq(sum(network.flits for network in networks)),
                     self.stalls.eq(sum(network.stalls for network in networks))]
        for node in range(routing.topology.nodes):
            m.submodules[f"interface_{node}"] = interface = NetworkInterface(
                config=self._config, routing=routing, node=node)
            wiring.connect(m, wiring.flipped(self.i_request[node]), interface.i_request)
            wiring.connect(m, wiring.flipped(self.i_reply[node]), interface.i_reply)
            wiring.connect(m, interface.o_request, wiring.flipped(self.o_request[node]))
            wiring.connect(m, interface.o_reply, wiring.flipped(self.o_reply[node]))
            m.d.comb += self.fault[node].eq(interface.fault)
            for number, network in enumerate(networks):
                wiring.connect(m, interface.o[number], network.i[node])
                wiring.connect(m, network.o[node], interface.i[number])
                m.d.comb += [interface.i_credit[number].eq(network.o_credit[node]),
                             network.i_credit[node].eq(interface.o_credit[number])]
        return m
