"""Benches of the network on chip."""
