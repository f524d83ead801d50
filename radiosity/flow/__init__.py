"""What is made of the RTL: Verilog and its packages, the simulated machine, area and clock, bitstreams."""
