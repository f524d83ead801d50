"""Verilog of engines, made once for each configuration."""

import hashlib
import json
from pathlib import Path

from golden.config import Config
from hw.export import cluster_verilog, engine_verilog
from tb.lib.runner import BUILD

__all__ = ["engine_text"]

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


def engine_text(config: Config) -> str:
    """The engine with its cluster, from a file if the same sources have made one before."""
    key = hashlib.sha256(SOURCES + json.dumps(config.parameters(), sort_keys=True).encode()).hexdigest()[:24]
    path = BUILD / "verilog" / f"engine-{key}.v"
    if not path.exists():
        text = engine_verilog(config) + cluster_verilog(config)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return path.read_text()
