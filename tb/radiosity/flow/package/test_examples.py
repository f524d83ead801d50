"""The examples of exported units run from the folder of the export alone, and notice what is wrong."""

import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from golden.engine.config import PRESETS
from radiosity.flow.package.example.link_example import FLITS
from radiosity.flow.package.example.stream_example import SCRIPTS, stream_example
from tb.lib.runner import tools
from tb.radiosity.flow.package.exported_engine import written
from tb.radiosity.flow.package.test_dialects import DIALECTS


def make(folder, *goal):
    """What a goal of the example's Makefile prints, and whether it passes."""
    with tools():
        # As a user calls it: options for the project's own builds name their model.
        environment = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
        done = subprocess.run(["make", "-C", folder / "example", *goal], capture_output=True, text=True,
                              check=False, env=environment)
    return done.stdout, done.returncode == 0


def passes(folder, goal):
    text, is_right = make(folder, goal)
    assert is_right, text
    (flits,) = re.findall(r"^(\d+) flits in \d+ cycles, 0 cycles differ: PASS$", text, re.MULTILINE)
    assert int(flits) >= FLITS


def cycles_of(folder, *goal):
    """Of a unit's bench that passes."""
    text, is_right = make(folder, *goal)
    assert is_right, text
    (cycles,) = re.findall(r"^\d+ items in (\d+) cycles, 0 wrong: PASS$", text, re.MULTILINE)
    return int(cycles)


@pytest.mark.icarus
@pytest.mark.sim
def test_four_exported_routers_carry_ten_thousand_flits(router, tmp_path):
    """Each in golden's cycle; a flit that differs in one bit is noticed."""
    folder, files = router
    assert files["example/network.v"].count(b"  radiosity_router router_") == 4
    passes(folder, "check")
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    words = files["example/required.hex"].decode().splitlines()
    number = next(number for number, word in enumerate(words) if word.strip("0") and not word.startswith("//"))
    words[number] = f"{int(words[number], 16) ^ 2:0{len(words[number])}x}"
    (tmp_path / "example" / "required.hex").write_text("\n".join(words))
    text, is_right = make(tmp_path, "check")
    assert not is_right
    assert "1 cycles differ: FAIL" in text


# Topology, channels, kinds of messages, arbitration.
NETWORKS = {"mesh": {}, "torus": {"noc.topology": "torus", "noc.columns": 4, "noc.virtual_channels": 2,
                                  "noc.networks": "virtual"},
            "ring": {"noc.topology": "ring", "noc.columns": 3, "noc.rows": 1, "noc.virtual_channels": 2,
                     "noc.arbitration": "age", "noc.router_cycles": 1, "noc.check": "crc", "noc.flit_bits": 40},
            "hypercube": {"noc.topology": "hypercube", "noc.columns": 4}}


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("network", NETWORKS)
@pytest.mark.parametrize("top", ["router", "network"])
def test_every_network_in_every_simulator(top, network, tmp_path):
    written(tmp_path, "--top", top, "--preset", "small",
            *(word for path, value in NETWORKS[network].items() for word in ("-P", f"{path}={value}")))
    for goal in "check", "verilator":
        passes(tmp_path, goal)
    for simulator in "icarus", "verilator":
        assert make(tmp_path, "cocotb", f"SIM={simulator}", f"PYTHON={sys.executable}")[1]


@pytest.fixture(scope="module")
def examples():
    """By unit the files of its example."""
    return {top: stream_example(top, f"radiosity_{top}", PRESETS["tiny"]) for top in SCRIPTS}


def lines_of(files, stream):
    return [int(line, 16) for line in files[f"example/{stream}.hex"].splitlines()]


@pytest.mark.parametrize("top", SCRIPTS)
def test_a_bench_has_every_port_and_every_item(top, examples, facts_of):
    """Each port of the manifest is connected, and each source and sink has as many items as its file."""
    files = examples[top]
    connected = re.findall(r"\.(\w+)\(", re.search(rf"  radiosity_{top} unit \((.*?)\);\n", files["example/bench.v"],
                                                    re.DOTALL)[1])
    assert sorted(connected) == sorted(port["name"] for port in facts_of(top)["ports"])
    counts = re.findall(r'\.COUNT\((\d+)\).*?\.FILE\("(\w+)\.hex"\)', files["example/bench.v"], re.DOTALL)
    assert {f"example/{stream}.hex" for _, stream in counts} == {path for path in files if path.endswith(".hex")}
    for count, stream in counts:
        assert len(lines_of(files, stream)) == int(count)
        assert f"'{stream}'" in files["example/test_bench.py"]


def test_settled_rays_end_grid_rays_in_the_bench_of_the_traversal_unit(examples, monkeypatch):
    """With nothing settled it would have more cells."""
    monkeypatch.setattr("radiosity.flow.package.example.ctu_script.settle_code", lambda inverse,
                        config: np.zeros_like(inverse))
    unsettled = stream_example("ctu", "radiosity_ctu", PRESETS["tiny"])
    assert 0 < len(lines_of(examples["ctu"], "o")) < len(lines_of(unsettled, "o"))


def test_a_cluster_requests_from_others_and_from_main_memory_in_its_bench(examples):
    """Both have replies, and together with its own patches all are there."""
    files = examples["cluster"]
    for request in "o_request", "o_bus":
        assert lines_of(files, request)


@pytest.mark.parametrize(("top", "config"), [
    ("ctu", PRESETS["thesis"]), ("icu", PRESETS["tiny"].replace({"icu.rays": 256})),
    ("cluster", PRESETS["tiny"].replace({"memsys.own_entries": 64}))], ids=["lists of subshells", "rays", "entries"])
def test_units_that_are_too_small_have_no_bench(top, config):
    assert stream_example(top, f"radiosity_{top}", config) == {}


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("top", SCRIPTS)
def test_every_unit_in_every_simulator_and_dialect(top, tmp_path):
    """From the folder alone; the cycles are the same in all dialects and in Verilator. A wrong bit is noticed."""
    written(tmp_path, "--top", top, "--preset", "tiny")
    cycles = cycles_of(tmp_path, "verilator")
    for standard in DIALECTS:
        assert cycles_of(tmp_path, "clean", "check", f"STANDARD={standard}") == cycles
    for simulator in "icarus", "verilator":
        assert make(tmp_path, "cocotb", f"SIM={simulator}", f"PYTHON={sys.executable}")[1]
    required = {"icu": "o_hit", "ctu": "o", "cluster": "o_write_data"}[top]
    path = tmp_path / "example" / f"{required}.hex"
    notice, first, *others = path.read_text().splitlines()
    path.write_text("\n".join([notice, f"{int(first, 16) ^ 1:0{len(first)}x}", *others]))
    text, is_right = make(tmp_path, "verilator")
    assert not is_right
    assert ": FAIL" in text
