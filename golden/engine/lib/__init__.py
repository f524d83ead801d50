"""Fixed-point numbers and CORDIC, which several blocks use."""
