"""The documentation's pictures."""

from pathlib import Path

from golden.scene.builtin import BUILTIN
from radiosity.cli.run import run

__all__ = ["write_pictures"]

# The Cornell box is square.
SIZES = {"cornell": "320x320"}
SIZE = "320x240"
# The image that the machine renders, of few elements.
MACHINE = ("cornell", "--size", "128x128", "--spp", "1", "--rays", "32x8", "--max-edge", "200", "--method", "machine",
           "--clusters", "4")


def write_pictures(folder: Path) -> list[Path]:
    """Render each built-in scene by the command that a user would give, and one image by the machine.

    Raises
    ------
    click.exceptions.Exit
        A command fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        run(folder, "render", name, "-o", f"{name}.png", "--size", SIZES.get(name, SIZE), "--spp", "9")
    run(folder, "render", *MACHINE, "-o", "machine.png")
    return [folder / f"{name}.png" for name in (*BUILTIN, "machine")]
