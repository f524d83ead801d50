"""Measurements: tables of what things take, written by ``make bench``. No test depends on them."""
