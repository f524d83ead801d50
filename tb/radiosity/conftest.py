"""Machines whose kernels Python runs."""

from tb.golden.machines.interpreted import interpreted

__all__ = ["interpreted"]
