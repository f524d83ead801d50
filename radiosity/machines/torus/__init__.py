"""Machine C: rays that travel between nodes of a torus that each own a box of space, simulated."""
