"""``pictures``: the documentation's pictures."""

from pathlib import Path

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.parameters import FILE
from radiosity.cli.run import run

__all__ = ["pictures"]

# The Cornell box is square.
_SIZES = {"cornell": "320x320"}
_SIZE = "320x240"
# The image that the machine renders, of few elements.
_MACHINE = ("cornell", "--size", "128x128", "--spp", "1", "--rays", "32x8", "--max-edge", "200", "--method", "machine",
            "--clusters", "4")


@click.command("pictures", cls=Task, extra="sim", short_help="Render the documentation's pictures.")
@click.argument("folder", type=FILE, default=Path("docs/pictures"))
def pictures(folder):
    """Render one picture for each built-in scene, and one by the simulated machine, into FOLDER.

    FOLDER is docs/pictures unless given.
    """
    from golden.scene.builtin import BUILTIN
    from radiosity.cli.check_simulator import check_simulator

    check_simulator()
    folder.mkdir(parents=True, exist_ok=True)
    for name in BUILTIN:
        run(folder, "render", name, "-o", f"{name}.png", "--size", _SIZES.get(name, _SIZE), "--spp", "9")
    run(folder, "render", *_MACHINE, "-o", "machine.png")
    paths = [folder / f"{name}.png" for name in (*BUILTIN, "machine")]
    console().report({"output": paths}, f"\n{len(paths)} pictures in {folder}")
