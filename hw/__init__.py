"""The machine in Amaranth, block for block as in `golden.engine`."""
