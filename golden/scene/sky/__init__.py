"""Skies with the sun."""
