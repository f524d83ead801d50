"""Tests and benches of all packages, in the folders of what they test; those of `hw` are here, without its name."""
