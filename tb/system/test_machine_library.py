"""Compiled machines: what was built is used again by those it fits, and by no others."""

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.simulator import machine_library as module
from radiosity.flow.simulator import machine_verilog
from radiosity.flow.simulator.build_folder import MOST_BYTES
from radiosity.flow.simulator.machine_library import machine_library
from tb.system.build_commands import write_made

CONFIG = PRESETS["tiny"]


@pytest.fixture
def builds(tmp_path, monkeypatch):
    """The sources of each build; nothing is exported or compiled."""
    found = []

    class Build:
        def __init__(self, folder, work, *_):
            self._folder, self._work = folder, work

        def run(self, *sources):
            found.append(sources)
            (self._work / "objects").write_bytes(bytes(2 * MOST_BYTES))
            (self._folder / "machine.so").write_text(str(len(found)))

    (tmp_path / "machine.cpp").write_text("int driver;")
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path / "build"))
    for name, value in (("top_verilog", lambda config, **given: "top"),
                        ("cluster_verilog", lambda config, **given: "cluster"),
                        ("export_beside", lambda config, **given: nullcontext()), ("_Build", Build),
                        ("HARNESS", tmp_path / "machine.cpp")):
        monkeypatch.setattr(module, name, value)
    return found


def test_the_same_machine_is_built_once(builds):
    assert machine_library(CONFIG) == machine_library(CONFIG)
    assert builds == [("top", "cluster")]


@pytest.mark.parametrize("change", ["top_verilog", "cluster_verilog", "HARNESS", "waveforms", "verilator_version",
                                    "_MAKE"])
def test_another_machine_is_built(builds, monkeypatch, tmp_path, change):
    first, options = machine_library(CONFIG), {}
    if change == "waveforms":
        options = {"traced": True}
    elif change == "HARNESS":
        (tmp_path / "machine.cpp").write_text("int another;")
    elif change == "_MAKE":
        monkeypatch.setattr(module, change, (*module._MAKE, "OPT_FAST=-O2"))
    else:
        monkeypatch.setattr(module, change, lambda *_, **given: "another")
    second = machine_library(CONFIG, **options)
    assert (first.read_text(), second.read_text()) == ("1", "2")
    assert machine_library(CONFIG, **options) == second
    assert len(builds) == 2


def test_intermediate_files_do_not_drive_others_out(builds, tmp_path, monkeypatch):
    first = machine_library(CONFIG)
    monkeypatch.setattr(module, "top_verilog", lambda config, **given: "another")
    second = machine_library(CONFIG)
    assert first.exists()
    assert {path.name for path in second.parent.iterdir()} == {"machine.so"}
    assert not list((tmp_path / "build").rglob("objects"))


def test_another_amaranth_exports_again(monkeypatch):
    before = machine_verilog._path("top", CONFIG)
    monkeypatch.setattr(machine_verilog, "_VERSIONS", ("0.0",))
    assert machine_verilog._path("top", CONFIG) != before


def test_just_exported_verilog_is_returned_though_it_exceeds_the_bound(monkeypatch, tmp_path):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    text = " " * (MOST_BYTES + 1)
    assert machine_verilog._exported("top", CONFIG, lambda config: text) == text
    assert machine_verilog._exported("top", CONFIG, lambda config: "again") == text


@pytest.mark.parametrize("clusters", [1, 2])
def test_a_build_leaves_library_and_log(monkeypatch, tmp_path, clusters):
    """With tools that write nothing but the required files; a cluster is compiled once."""
    commands = []

    def start(self, *command):
        commands.append(command)
        write_made(list(command), self._work)
        (self._folder / "build.log").write_text("done")
        return SimpleNamespace(wait=lambda: 0)

    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    monkeypatch.setattr(module._Build, "_start", start)
    monkeypatch.setattr(module, "export_beside", lambda config, **given: nullcontext())
    monkeypatch.setattr(module, "cluster_verilog", lambda config, **given: "cluster")
    config = CONFIG.replace({"noc.columns": clusters})
    for top in "one", "another":
        monkeypatch.setattr(module, "top_verilog", lambda config, top=top, **given: top)
        library = machine_library(config)
        assert {path.name for path in library.parent.iterdir()} == {"machine.so", "build.log"}
        assert library.read_text() == "part.so"
    assert not [path for path in (tmp_path / "parts").iterdir() if path.suffix != ".lock"]
    assert sum("--lib-create" in command for command in commands) == (clusters > 1)
