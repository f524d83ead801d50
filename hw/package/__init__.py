"""What is handed on of the hardware: Verilog with all that a design flow wants beside it."""
