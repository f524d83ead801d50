"""Casting: the nearest patch that each ray hits."""
