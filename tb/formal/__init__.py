"""Proofs: properties of components for all inputs, each with a broken twin that must fail."""
