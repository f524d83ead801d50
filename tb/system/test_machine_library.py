"""Compiled machines: what was built is used again by those it fits, and by no others."""

from contextlib import nullcontext

import pytest

from golden.config import PRESETS
from hw.simulator import machine_library as module
from hw.simulator.machine_library import machine_library

CONFIG = PRESETS["tiny"]


@pytest.fixture
def builds(tmp_path, monkeypatch):
    """The sources of each build; nothing is exported or compiled."""
    found = []

    class Build:
        def __init__(self, folder, *_):
            self._folder = folder

        def run(self, *sources):
            found.append(sources)
            (self._folder / "machine.so").write_text(str(len(found)))

    (tmp_path / "machine.cpp").write_text("int driver;")
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path / "build"))
    for name, value in (("top_verilog", lambda config: "top"), ("cluster_verilog", lambda config: "cluster"),
                        ("export_beside", lambda config: nullcontext()), ("_Build", Build),
                        ("HARNESS", tmp_path / "machine.cpp")):
        monkeypatch.setattr(module, name, value)
    return found


def test_the_same_machine_is_built_once(builds):
    assert machine_library(CONFIG) == machine_library(CONFIG)
    assert builds == [("top", "cluster")]


@pytest.mark.parametrize("change", ["top_verilog", "cluster_verilog", "HARNESS", "waveforms"])
def test_another_machine_is_built(builds, monkeypatch, tmp_path, change):
    first, options = machine_library(CONFIG), {}
    if change == "waveforms":
        options = {"traced": True}
    elif change == "HARNESS":
        (tmp_path / "machine.cpp").write_text("int another;")
    else:
        monkeypatch.setattr(module, change, lambda config: "another")
    second = machine_library(CONFIG, **options)
    assert (first.read_text(), second.read_text()) == ("1", "2")
    assert machine_library(CONFIG, **options) == second
    assert len(builds) == 2
