"""Benches of what joins the units."""
