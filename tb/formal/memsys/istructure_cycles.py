"""Cycles of the I-structure that its proofs assume."""

__all__ = ["CLOSING", "REFUSAL"]

# Cycles from a write to its refusal.
REFUSAL = 4
# Cycles for a sweep and for writes in flight.
CLOSING = 6
