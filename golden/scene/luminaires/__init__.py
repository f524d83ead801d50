"""Luminaires from files of their photometry."""
