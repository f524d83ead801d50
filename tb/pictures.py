"""Renders the documentation's pictures of all built-in scenes: ``python -m tb.pictures FOLDER``."""

import sys
from pathlib import Path

from golden.scene.builtin import BUILTIN
from tb.command import golden

OPTIONS = ("--size", "256x256", "--spp", "9")


def main(folder: Path) -> None:
    """One picture per scene, by the command that a user would give."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        golden(folder, "render", name, "-o", f"{name}.png", *OPTIONS)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
