"""Frusta cast in the machine's integers."""
