"""The machine in Amaranth. Empty so far: the golden model comes first, block by block the hardware follows it."""
