"""What a port raises where a register access is answered with an error."""

__all__ = ["RegisterError"]


class RegisterError(Exception):
    """A register access has been answered with an error response."""
