"""Renders the documentation's pictures of all built-in scenes: ``python -m tb.pictures FOLDER``."""

import subprocess
import sys
from pathlib import Path

from golden.scene.builtin import BUILTIN

OPTIONS = ["--size", "256x256", "--spp", "9"]


def main(folder: Path) -> None:
    """One picture per scene, by the command that a user would give."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        command = [sys.executable, "-m", "golden", "render", name, "-o", folder / f"{name}.png", *OPTIONS]
        subprocess.run(command, check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
