"""Benchmarks: what the machine and its parts take, measured and tabulated; `radiosity bench` runs them."""
