"""Counts with their noun."""

__all__ = ["counted"]


def counted(count: int, noun: str) -> str:
    """``1 cell``, ``2 cells``, ``2 patches``."""
    ending = "" if count == 1 else "es" if noun.endswith(("ch", "s", "x")) else "s"
    return f"{count} {noun}{ending}"
