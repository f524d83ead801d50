"""The examples of exported units run from the folder of the export alone, and notice what is wrong."""

import os
import re
import shutil
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from golden.engine.config import PRESETS
from hw.ctu.traversal_unit import TraversalUnit
from hw.lib.payload import unpack
from radiosity.flow.package.example.link_example import FLITS
from radiosity.flow.package.example.stream_example import SCRIPTS, stream_example
from radiosity.flow.package.example.templates import example_files
from tb.lib.runner import tools
from tb.radiosity.flow.package.exported_engine import DIALECTS, written


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


def test_stages_of_the_traversal_unit_are_steps_of_its_bench(examples):
    """Cells of a stage come in any order, and those of a later one behind them; the end is the last."""
    shape = TraversalUnit(config=PRESETS["tiny"]).o.payload.shape()
    steps, items = zip(*(divmod(line, 1 << 2 * shape.size) for line in lines_of(examples["ctu"], "o")), strict=True)
    stages = [unpack(shape, item & (1 << shape.size) - 1)["stage"] for item in items[:-1]]
    assert list(steps) == sorted(steps)
    assert steps[-1] > steps[-2]
    changes = [after != before for before, after in pairwise(stages)]
    assert [after != before for before, after in pairwise(steps[:-1])] == changes
    assert sum(changes) > 1


def icarus(folder, **files):
    """What a bench of these files prints."""
    for name, text in files.items():
        (folder / f"{name}.hex").write_text(text)
    subprocess.run(["iverilog", "-o", "bench", "bench.v"], cwd=folder, check=True)
    return subprocess.run(["vvp", "-N", "bench"], cwd=folder, check=True, capture_output=True, text=True).stdout


@pytest.mark.icarus
@pytest.mark.sim
@pytest.mark.parametrize(("order", "wrong"), [((1, 2, 3), 0), ((2, 1, 3), 0), ((1, 3, 2), 2)], ids=str)
def test_items_of_a_later_step_are_wrong_in_any_order(order, wrong, examples, tmp_path):
    modules, _, _ = examples["ctu"]["example/bench.v"].partition("module bench;")
    given = ", ".join(f"8'd{item}" for item in reversed(order))
    (tmp_path / "bench.v").write_text(modules + f"""
module bench;
  reg clk = 1'b0, rst = 1'b1;
  reg [31:0] cycle = 0;
  wire [23:0] given = {{{given}}};
  wire [31:0] came, wrong;
  sink #(.WIDTH(8), .COUNT(3), .ANY_ORDER(1), .STALLS(0), .FILE("o.hex")) o (
    .clk(clk), .rst(rst), .step(cycle < 2 ? 16'd0 : 16'd1), .over(1'b0), .valid(cycle < 3),
    .payload(given[8 * cycle +: 8]), .ready(), .done(), .came(came), .wrong(wrong));
  always #5 clk = !clk;
  always @(negedge clk) begin
    rst <= 1'b0;
    if (!rst) cycle <= cycle + 1;
    if (cycle == 5) begin
      $display("%0d came, %0d wrong", came, wrong);
      $finish;
    end
  end
endmodule
""")
    assert icarus(tmp_path, o="0000ff01\n0000ff02\n0001ff03\n").endswith(f"\n3 came, {wrong} wrong\n" if wrong
                                                                        else "3 came, 0 wrong\n")


@pytest.mark.icarus
@pytest.mark.sim
@pytest.mark.parametrize(("credit", "verdict"), [("0", "PASS"), ("x", "FAIL"), ("1", "FAIL")])
def test_an_unknown_credit_is_wrong(credit, verdict, tmp_path):
    bench = example_files("link", {"WIDTH": "3", "LINKS": "1", "LINK": "3", "CYCLES": "1", "FLITS": "1"})
    (tmp_path / "bench.v").write_text(bench["example/bench.v"] + f"""
module words (input clk, input rst, input [2:0] i, output [2:0] o);
  assign o = 3'b{credit}11;
endmodule
""")
    assert verdict in icarus(tmp_path, given="0\n", required="3\n")


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
