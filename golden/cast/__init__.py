"""Casting in double precision: rays, hemispheres and screens, and the nearest patch that each ray hits."""
