"""Stimuli of the blocks of the cell traversal unit."""
