"""The engine's control, cycle by cycle."""
