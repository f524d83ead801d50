"""Exports of the hardware: Verilog with the files that design flows need."""
