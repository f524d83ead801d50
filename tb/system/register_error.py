"""What a port says of registers that answer with an error."""

__all__ = ["RegisterError"]


class RegisterError(Exception):
    """A register has been answered with an error."""
