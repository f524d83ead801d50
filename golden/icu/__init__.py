"""Intersection computation, bit for bit: from a patch and a bundle of rays to the rays' nearest hits."""
