"""Verilog of an engine and of its cluster, exported once for each configuration."""

import json
import os
from collections.abc import Callable
from pathlib import Path

from golden.config import Config
from golden.noc.topology import TOPOLOGIES
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from hw.export import verilog_of
from hw.simulator.build_folder import build_folder, content_key, keep_newest

__all__ = ["cluster_verilog", "engine_verilog", "top_verilog"]

_ROOT = Path(__file__).parents[2]


def _sources() -> str:
    """All Python files that an engine is generated from."""
    return content_key(*(path.read_text() for folder in ("hw", "golden")
                         for path in sorted((_ROOT / folder).rglob("*.py"))))


# As they are when they are imported: the files may change while this program runs.
_SOURCES = _sources()


def _exported(name: str, config: Config, export: Callable[[Config], str]) -> str:
    """The text from a file if the same sources have exported it before."""
    key = content_key(_SOURCES, json.dumps(config.parameters(), sort_keys=True))
    path = build_folder() / "verilog" / f"{name}-{key}.v"
    if not path.exists():
        text = export(config)
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(f".part{os.getpid()}")
        part.write_text(text)
        part.replace(path)
        keep_newest(path.parent)
    return path.read_text()


def top_verilog(config: Config) -> str:
    """The engine without the module of its clusters, which is a black box in it."""
    return _exported("top", config, lambda config: verilog_of(Engine(config=config, black_boxes=True), "top"))


def cluster_verilog(config: Config) -> str:
    """The module of an engine's clusters. It depends on the number of nodes only: all topologies share it."""
    return _exported("cluster", config.replace({"noc.topology": TOPOLOGIES[0]}),
                     lambda config: verilog_of(Cluster(config=config), CLUSTER))


def engine_verilog(config: Config) -> str:
    """The engine with its cluster."""
    return top_verilog(config) + cluster_verilog(config)
