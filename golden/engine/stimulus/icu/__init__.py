"""Stimuli of the blocks of intersection computation."""
