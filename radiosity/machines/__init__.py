"""Simulators of whole machines: discrete events, driven by the golden model's work."""
