"""Example benches of exported units: plain Verilog and cocotb, with the golden model's stimuli and results."""
