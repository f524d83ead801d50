"""Benches of the registers."""
