"""Parameters of routers and networks of a configuration."""

from typing import Any

from golden.engine.config import Config
from hw.lib.arbiter import ArbiterPolicy
from hw.noc.noc_tables import CHECK_BITS, route

__all__ = ["network_parameters"]

_POLICIES = {"round-robin": ArbiterPolicy.ROUND_ROBIN, "age": ArbiterPolicy.LONGEST_WAITING}


def network_parameters(config: Config) -> dict[str, Any]:
    """Those of `Network`, and but for the node those of `Router`."""
    noc = config.noc
    return {"routing": route(noc.network(), noc.virtual_channels), "bits": noc.flit_bits + CHECK_BITS[noc.check],
            "depth": noc.buffer_flits, "messages": 1 if noc.networks == "physical" else 2,
            "router_cycles": noc.router_cycles, "policy": _POLICIES[noc.arbitration]}
