"""Intersection computation in hardware, block for block as in `golden.engine.icu`."""
