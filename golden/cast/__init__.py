"""Casting: which patch a ray meets first."""
