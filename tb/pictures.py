"""Renders the documentation's pictures of all built-in scenes: ``python -m tb.pictures FOLDER``."""

import sys
from pathlib import Path

from golden.scene.builtin import BUILTIN
from tb.command import golden

# The Cornell box is square.
SIZES = {"cornell": "320x320"}
SIZE = "320x240"


def main(folder: Path) -> None:
    """One picture per scene, by the command that a user would give."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        golden(folder, "render", name, "-o", f"{name}.png", "--size", SIZES.get(name, SIZE), "--spp", "9")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
