"""Renders the documentation's pictures: ``python -m tb.pictures FOLDER``."""

import sys
from pathlib import Path

from golden.scene.builtin import BUILTIN
from tb.command import golden, machine
from tb.demo import MACHINE, RENDERED

# The Cornell box is square.
SIZES = {"cornell": "320x320"}
SIZE = "320x240"


def main(folder: Path) -> None:
    """One picture per built-in scene, by the command that a user would give, and one by the machine."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        golden(folder, "render", name, "-o", f"{name}.png", "--size", SIZES.get(name, SIZE), "--spp", "9")
    machine(folder, "render", *RENDERED, "-o", "machine.png", *MACHINE)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
