"""Intersection computation, bit-exact: from a patch and a bundle of rays to the nearest hits."""
