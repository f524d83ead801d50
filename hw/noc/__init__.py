"""The network on chip."""
