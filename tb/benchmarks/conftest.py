"""Simulators whose kernels Python runs."""

from tb.radiosity.machines.interpreted import interpreted

__all__ = ["interpreted"]
