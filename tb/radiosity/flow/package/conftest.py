"""Fixtures of the tests of exported cores."""

import functools
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.package.core_files import write_core
from radiosity.flow.package.manifest import manifest
from radiosity.flow.package.tops import Top
from tb.radiosity.flow.package.exported_engine import CONFIG, written


@pytest.fixture
def without_verilog(monkeypatch):
    """Exports of engines whose Verilog is empty."""
    _omit_verilog(monkeypatch)


def _omit_verilog(patch):
    patch.setattr(Top, "verilog", lambda *_: "")
    patch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})


@pytest.fixture(scope="session")
def facts_of() -> Callable[[str], dict]:
    """From a top to its manifest without Verilog and latencies, made once."""
    @functools.cache
    def facts(top):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})
            return manifest(top, f"radiosity_{top}", config=PRESETS["tiny"], preset="tiny", text="")

    return facts


@pytest.fixture(scope="session")
def exported(tmp_path_factory) -> Path:
    """The folder of an exported engine with one cluster, whose Verilog is empty; what changes it takes `core`."""
    folder = tmp_path_factory.mktemp("exported")
    with pytest.MonkeyPatch.context() as patch:
        _omit_verilog(patch)
        write_core("engine", config=CONFIG, preset="tiny", folder=folder)
    return folder


@pytest.fixture
def core(exported, tmp_path) -> Path:
    """A copy of `exported`."""
    return shutil.copytree(exported, tmp_path / "core")


@pytest.fixture(scope="session")
def router(tmp_path_factory) -> tuple[Path, dict[str, bytes]]:
    """The folder of an exported router, and its files."""
    folder = tmp_path_factory.mktemp("router")
    return folder, written(folder, "--top", "router", "--preset", "small")
