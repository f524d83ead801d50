"""Verilog of components, and of the engine with its clusters as one module."""

import os

from amaranth.back import verilog
from amaranth.lib import wiring

from golden.config import Config
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from hw.lib.apart import ports_of

__all__ = ["cluster_verilog", "engine_verilog", "verilog_of"]


def verilog_of(component: wiring.Component, name: str) -> str:
    """A component as the module ``name``, its ports by the names of its members."""
    os.environ["AMARANTH_USE_YOSYS"] = "builtin"
    return verilog.convert(component, name=name, ports=ports_of(component), emit_src=False,
                           strip_internal_attrs=True)


def cluster_verilog(config: Config) -> str:
    """The cluster, all of the same."""
    return verilog_of(Cluster(config=config), CLUSTER)


def engine_verilog(config: Config, *, name: str = "top", **options) -> str:
    """The engine around instances of its cluster.

    Parameters
    ----------
    options
        Of `Engine`.
    """
    return verilog_of(Engine(config=config, apart=True, **options), name)
