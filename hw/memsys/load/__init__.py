"""Loads: the tables of a memory image, checked, word by word."""
