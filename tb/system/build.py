"""Verilog of engines, made once for each configuration."""

import hashlib
import json
from contextlib import contextmanager
from pathlib import Path

from amaranth.back import rtlil

from golden.config import Config
from hw.package.tops import engine_verilog
from tb.lib.runner import BUILD

__all__ = ["ROOT", "engine_text"]

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


@contextmanager
def _unwritten_zeros():
    """Memories that begin with zeros are left to the simulator, which begins with them too: to write down every bit of
    them would take many times as long as all the rest.
    """
    written = rtlil.ModuleEmitter.emit_memory

    def emit_memory(emitter, number, cell):
        if any(cell.init):
            written(emitter, number, cell)

    rtlil.ModuleEmitter.emit_memory = emit_memory
    try:
        yield
    finally:
        rtlil.ModuleEmitter.emit_memory = written


def engine_text(config: Config) -> str:
    """The engine with its cluster, from a file if the same sources have made one before.

    For Verilator with its variables 0 at first: of memories nothing is said that begin with zeros.
    """
    key = hashlib.sha256(SOURCES + json.dumps(config.parameters(), sort_keys=True).encode()).hexdigest()[:24]
    path = ROOT / BUILD / "verilog" / f"engine-{key}.v"
    if not path.exists():
        with _unwritten_zeros():
            text = engine_verilog(config)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return path.read_text()
