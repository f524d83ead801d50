"""Verilog of engines, made once for each configuration."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

from golden.config import Config
from golden.noc.topology import TOPOLOGIES
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from hw.export import verilog_of
from tb.lib.runner import BUILD

__all__ = ["ROOT", "cluster_text", "engine_text", "frame_text"]

ROOT = Path(__file__).parents[2]


def _digest():
    """Of all that an engine is made from."""
    digest = hashlib.sha256()
    for folder in ("hw", "golden"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


# As they are when they are imported: they may change while this runs.
SOURCES = _digest()


def _text(name: str, config: Config, make: Callable[[Config], str]) -> str:
    """Made, or from a file if the same sources have made it before."""
    key = hashlib.sha256(SOURCES + json.dumps(config.parameters(), sort_keys=True).encode()).hexdigest()[:24]
    path = ROOT / BUILD / "verilog" / f"{name}-{key}.v"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(make(config))
    return path.read_text()


def frame_text(config: Config) -> str:
    """The engine without the module of its clusters."""
    return _text("frame", config, lambda config: verilog_of(Engine(config=config, apart=True), "top"))


def cluster_text(config: Config) -> str:
    """The module of an engine's clusters. Of the network it knows how many nodes there are: topologies share it."""
    return _text("cluster", config.replace({"noc.topology": TOPOLOGIES[0]}),
                 lambda config: verilog_of(Cluster(config=config), CLUSTER))


def engine_text(config: Config) -> str:
    """The engine with its cluster."""
    return frame_text(config) + cluster_text(config)
