"""What every table says of where it was measured, and how it is written."""

import platform
from importlib.metadata import version
from pathlib import Path

import click

__all__ = ["provenance", "write_report"]


def provenance(*packages: str) -> str:
    """Machine and versions."""
    return ", ".join([platform.machine(), f"Python {platform.python_version()}",
                      *(f"{name} {version(name)}" for name in packages)])


def write_report(path: Path, lines: list[str]) -> None:
    """Write a page and say where."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")
    click.echo(f"wrote {path}")
