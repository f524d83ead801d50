"""The machine on a board: main memory in block RAM, what a host does as a program, and a serial line for results."""
