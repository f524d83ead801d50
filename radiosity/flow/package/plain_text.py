"""Texts of the tables for languages that know no Markdown."""

import re

__all__ = ["plain_text"]


def plain_text(about: str) -> str:
    """A text without links, which lead nowhere outside the documentation, for a string of C or SystemRDL in quotes."""
    return re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", about).replace("\\", "\\\\").replace('"', '\\"')
