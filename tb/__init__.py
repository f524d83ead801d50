"""Tests and benches: what proves the golden model, and later the hardware, folder for folder."""
