"""Waveforms of the simulated machine: which signals they have, and which of them a viewer shows."""

import re

from radiosity.flow.simulator.traced_verilog import traced_verilog
from radiosity.flow.simulator.wave_view import write_wave_view

VERILOG = """\
module unit(clk, i__valid, o__payload);
  wire \\$1 ;
  reg [3:0] \\$2 ;
  input clk;
  wire clk;
  input i__valid;
  wire i__valid;
  wire \\i__valid$5 ;
  reg [7:0] count = 8'h00;
  wire [7:0] next;
  reg [7:0] memory [15:0];
  output [7:0] o__payload;
  wire [7:0] o__payload;
  part part (
    .clk(clk)
  );
endmodule
module part(clk);
  wire other;
  input clk;
  wire clk;
endmodule
"""
WAVES = """\
$scope module TOP $end
 $var wire 1 a axi__arvalid $end
 $scope module top $end
  $var wire 1 a axi__arvalid $end
  $var wire 1 b clk $end
  $scope module bus $end
   $var wire 8 c i__payload [7:0] $end
  $upscope $end
  $scope module cluster_0 $end
   $var wire 8 d i_word__payload [7:0] $end
   $scope module placed $end
    $scope module memory $end
     $var wire 1 e i__valid $end
     $scope module memory $end
      $var wire 1 f i__valid $end
     $upscope $end
    $upscope $end
   $upscope $end
  $upscope $end
 $upscope $end
$upscope $end
$enddefinitions $end
#0
1a
"""


def traced(text):
    """Names of the declarations that have waveforms; instances must have them too."""
    names, on = [], True
    for line in text.splitlines():
        if "verilator tracing_" in line:
            on = "tracing_on" in line
        elif found := re.match(r" *(?:wire|reg) (?:\[.*?\] )?(\S+?)[ ;]", line):
            names += [found[1]] * on
        elif line.startswith(("module", "  part")):
            assert on
    return names


def test_ports_and_named_registers_have_waveforms():
    text = traced_verilog(VERILOG)
    assert traced(text) == ["clk", "i__valid", "count", "o__payload", "clk"]
    assert "".join(line for line in text.splitlines(keepends=True) if "tracing_" not in line) == VERILOG


def test_a_view_has_the_ports_of_engine_clusters_and_units(tmp_path):
    (tmp_path / "cast.vcd").write_text(WAVES)
    write_wave_view(tmp_path / "cast.vcd", tmp_path / "cast.gtkw")
    lines = (tmp_path / "cast.gtkw").read_text().splitlines()
    assert lines[0] == '[dumpfile] "cast.vcd"'
    shown = [line for line in lines if line.startswith(("-", "TOP"))]
    assert shown == [
        "-engine", "TOP.top.axi__arvalid", "-engine", "-cluster_0", "TOP.top.cluster_0.i_word__payload[7:0]",
        "-cluster_0", "-cluster_0 memory", "TOP.top.cluster_0.placed.memory.i__valid", "-cluster_0 memory"]
