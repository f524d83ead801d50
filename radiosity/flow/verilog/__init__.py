"""Verilog of components, in forms that simulators and synthesis agree on."""
