"""The components that can be exported."""

from collections.abc import Callable
from dataclasses import dataclass

from amaranth.lib import wiring

from golden.engine.config import Config
from hw.async_engine import AsyncEngine
from hw.cluster import Cluster
from hw.ctu.traversal_unit import TraversalUnit
from hw.engine import CLUSTER, Engine
from hw.icu.intersection_unit import IntersectionUnit
from hw.noc.network import Network
from hw.noc.network_parameters import network_parameters
from hw.noc.router import Router
from radiosity.flow.package.port_names import port_name
from radiosity.flow.verilog.export import verilog_of

__all__ = ["TOPS", "Top"]


@dataclass(frozen=True, kw_only=True)
class Top:
    """A component and the text of its module.

    Parameters
    ----------
    about
        What it is, in a line.
    make
        The component, from a configuration.
    parts
        The components that are black boxes in it, from a configuration: none, or the cluster.
    period
        Nanoseconds of a cycle that place and route has reached in some configuration: of units and the cluster by
        `docs/figures/history.csv`, of an engine as a part of the board's SoC.
    is_engine
        It has registers, and software drives it.
    is_network
        Its streams carry flits.
    buses
        Those with a clock and a reset of their own, ``BUS_aclk`` and ``BUS_aresetn``.
    """

    about: str
    period: float
    make: Callable[[Config], wiring.Component]
    parts: tuple[Callable[[Config], wiring.Component], ...] = ()
    is_engine: bool = False
    is_network: bool = False
    buses: tuple[str, ...] = ()

    @property
    def clocks(self) -> tuple[str, ...]:
        """Ports that are clocks."""
        return "clk", *(f"{bus}_aclk" for bus in self.buses)

    def verilog(self, config: Config, name: str) -> str:
        """The module ``name``, its ports by `port_name`, and all below it; all clusters are one module."""
        return verilog_of(self.make(config), name, port_name=port_name) + "".join(
            verilog_of(part(config), CLUSTER) for part in self.parts)


def _cluster(config):
    return Cluster(config=config)


def _router(config):
    """Of any node of the configuration's network."""
    return Router(node=None if config.noc.nodes > 1 else 0, **network_parameters(config))


TOPS = {
    "engine": Top(about="Ray-casting accelerator: AXI4-Lite registers, an AXI4 manager, clusters and their network",
                  period=25, make=lambda config: Engine(config=config, black_boxes=True),
                  parts=(_cluster,), is_engine=True),
    "async_engine": Top(about="Ray-casting accelerator whose registers and memory port have clocks of their own",
                        period=25, make=lambda config: AsyncEngine(config=config, black_boxes=True),
                        parts=(_cluster,), is_engine=True, buses=("m_axi", "s_axil")),
    "cluster": Top(about="One cluster of the engine: cell traversal, memory system and intersection", period=13,
                   make=_cluster),
    "icu": Top(about="Intersection computation unit: patches against the rays of their windows",
               period=10, make=lambda config: IntersectionUnit(config=config)),
    "ctu": Top(about="Cell traversal unit: the cells of the rays of subshells", period=11,
               make=lambda config: TraversalUnit(config=config,
                                                 pipelines=config.ctu.traversal_pipelines(config.noc.clusters))),
    "network": Top(about="The patch network's routers and the links between them, with a port for each node", period=9,
                   make=lambda config: Network(**network_parameters(config)), is_network=True),
    "router": Top(about="Wormhole router of the patch network, its node an input", period=9, make=_router,
                  is_network=True),
}
