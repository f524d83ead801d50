"""Stimuli of the blocks of cell traversal."""
