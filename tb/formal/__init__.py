"""Proofs: properties of components for all inputs, each with a negative control that must fail."""
