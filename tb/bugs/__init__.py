"""Bugs that are drawn in the sources, to measure what the tests notice."""
