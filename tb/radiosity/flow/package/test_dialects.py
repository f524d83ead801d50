"""Exported cores in each dialect of Verilog: the same in all of them after a reset, and never unknown.

The bench is Verilog 2005 and made from the manifest alone.
"""

import json
import re
import subprocess

import pytest

from tb.lib.runner import tools
from tb.radiosity.flow.package.exported_engine import DIALECTS, written

RESETS = 1, 2, 8
# Cycles without a request after a reset.
IDLE = 100
BENCH = """
`timescale 1ns/1ps
module bench;
  reg clk = 0;
  integer now = 0;
  always #5 clk = ~clk;
  always @(posedge clk) now <= now + 1;
{declared}
  {name} core ({connected});
  task check;
    begin
{checks}
    end
  endtask
{tasks}
  initial begin
{steps}
    $finish;
  end
endmodule
"""
READ = """
  task read(input integer address);
    begin
      s_axil_araddr = address;
      s_axil_arvalid = 1;
      s_axil_rready = 1;
      @(negedge clk);
      while (!s_axil_arready) @(negedge clk);
      @(negedge clk);
      s_axil_arvalid = 0;
      while (!s_axil_rvalid) @(negedge clk);
      check;
      $display("%0d: %h is %h, %h", now, address, s_axil_rdata, s_axil_rresp);
      @(negedge clk);
      s_axil_rready = 0;
    end
  endtask
"""


def unknown(port, condition):
    """A statement that prints the port if it is unknown under a condition."""
    return f'      if ({condition} && ^{port} === 1\'bx) $display("%0d: {port} is %b", now, {port});'


def bench(facts):
    """Resets of so many cycles, idle cycles, and a read of each register; no port may be unknown that counts."""
    ports = [port for port in facts["ports"] if port["name"] != "clk"]
    outputs = {port["name"] for port in ports if port["direction"] == "output"}
    checks = []
    for name in sorted(outputs):
        payload = re.fullmatch(r"(.*_)payload|((?:s_axil|m_axi)_(?:aw|ar|w|r|b))(?!valid|ready).+", name)
        valid = f"{payload[1] or payload[2]}valid" if payload else ""
        checks.append(unknown(name, valid if valid in outputs else "1"))
    steps = []
    for cycles in RESETS:
        steps += ["    rst = 1;", f"    repeat ({cycles}) @(negedge clk);", "    rst = 0;",
                  f"    repeat ({IDLE}) begin @(negedge clk); check; end"]
        steps += [f"    read({one['address'] + offset});" for one in facts.get("registers", ())
                  for offset in range(0, 4 * -(-one["bits"] // 32), 4)]
        steps.append(f"    repeat ({IDLE}) begin @(negedge clk); check; end")
    names = [port["name"] for port in ports]
    return BENCH.format(
        name=facts["name"], connected=", ".join(f".{name}({name})" for name in ("clk", *names)),
        declared="\n".join(f"  {'wire' if port['name'] in outputs else 'reg'} [{port['width'] - 1}:0] {port['name']}"
                           f"{'' if port['name'] in outputs else ' = 0'};" for port in ports),
        checks="\n".join(checks), tasks=READ if "registers" in facts else "", steps="\n".join(steps))


def in_icarus(folder, name, dialect):
    """What the bench prints."""
    program = folder / f"{dialect}.vvp"
    subprocess.run(["iverilog", f"-g{dialect}", "-s", "bench", "-o", program, folder / "bench.v", folder / f"{name}.v"],
                   check=True)
    return subprocess.run(["vvp", program], check=True, capture_output=True, text=True).stdout


def in_verilator(folder, name, kind):
    """What the bench prints, from random initial values."""
    with tools():
        subprocess.run(["verilator", "--binary", "-Wno-fatal", "-Wno-lint", "--x-initial", "unique", "--x-assign",
                        "unique", "--top-module", "bench", "--Mdir", folder / f"verilated_{kind}", folder / "bench.v",
                        folder / f"{name}.{kind}"], check=True, capture_output=True)
    done = subprocess.run([folder / f"verilated_{kind}" / "Vbench", "+verilator+rand+reset+2", "+verilator+seed+7"],
                          check=True, capture_output=True, text=True).stdout
    return "".join(line for line in done.splitlines(keepends=True) if not line.startswith("-"))


def made(folder, *arguments):
    """A core with its bench, and its manifest."""
    files = written(folder, *arguments)
    (manifest,) = [json.loads(text) for name, text in files.items() if name.endswith(".json")]
    (folder / "bench.v").write_text(bench(manifest))
    return manifest


def check_all(folder, *arguments, compiles=True):
    """Every dialect and simulator prints the same, and nothing that is unknown."""
    facts = made(folder, *arguments)
    expected, *others = (in_icarus(folder, facts["name"], dialect) for dialect in DIALECTS)
    read = sum(-(-one["bits"] // 32) for one in facts.get("registers", ()))
    assert "x" not in expected
    assert len(expected.splitlines()) == read * len(RESETS)
    assert others == [expected] * len(others)
    for kind in ("sv", "v") if compiles else ():
        assert in_verilator(folder, facts["name"], kind) == expected, kind


@pytest.mark.icarus
@pytest.mark.sim
def test_the_router(tmp_path):
    check_all(tmp_path, "--top", "router", "--preset", "small")


@pytest.mark.icarus
@pytest.mark.sim
def test_the_engine_in_icarus(tmp_path):
    check_all(tmp_path, "--preset", "tiny", "-P", "noc.columns=1", "-P", "noc.rows=1", compiles=False)


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("preset", ["tiny", "small"])
@pytest.mark.parametrize("top", ["engine", "cluster", "icu", "ctu"])
def test_each_top(top, preset, tmp_path):
    check_all(tmp_path, "--top", top, "--preset", preset)
