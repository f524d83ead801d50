"""Caches between clusters and main memory."""
