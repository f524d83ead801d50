"""Stimuli of the blocks of the memory unit."""
