"""Testbenches of the whole machine."""
