"""The machine in Amaranth. Empty so far: it follows the golden model block by block."""
