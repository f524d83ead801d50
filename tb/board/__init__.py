"""Benches of the board shell, and what reads what it sends."""
