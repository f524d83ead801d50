"""Real scenes, rendered and cast, with pictures and a report."""

import json
import platform
from importlib.metadata import version
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops
from scipy import sparse

from golden.package_version import DISTRIBUTION, package_version
from golden.processors import processors
from radiosity.run import run

__all__ = ["MACHINE", "RENDERED", "write_demo"]

# Name of the pictures, scene, options. The telephone is read from a file.
RENDERS = (
    ("cornell", "cornell", ("--size", "512x512")),
    ("room1627", "room1627", ("--size", "400x300")),
    ("phone", "phone.glb", ("--size", "400x300")),
    ("mountain", "mountain", ("--size", "400x300")),
)

# The image that the machine renders, of few elements.
RENDERED = ("cornell", "--size", "128x128", "--spp", "1", "--rays", "32x8", "--max-edge", "200")
MACHINE = ("--method", "machine", "--clusters", "4")


def picture(folder: Path, name: str, scene: str, options: tuple[str, ...]) -> list[str]:
    """A section of the report: command, picture, heat map, and what it took."""
    line = run(folder, "render", scene, "-o", f"{name}.png", "-o", f"{name}.exr", "--heatmap", name,
                  "--stats", f"{name}.json", *options)
    stats = json.loads((folder / f"{name}.json").read_text())
    rows = [f"| {kind} | {counts['rays']:,} | {counts['hits']:,} | {counts['tests'] / max(1, counts['rays']):.2f} "
            f"| {counts['steps'] / max(1, counts['rays']):.2f} |"
            for kind, counts in {**stats["rays"], "total": stats["total"]}.items()]
    seconds = [f"{stage} {value:.1f} s" for stage, value in stats["seconds"].items()]
    return [f"## {name}", "", f"`{line}`", "",
            f"![{name}]({name}.png) ![patch tests per pixel]({name}-tests.png)", "",
            f"{stats['patches']} patches, {stats['elements']} elements; {', '.join(seconds)}", "",
            "| rays | cast | hit | tests per ray | cell steps per ray |", "|---|--:|--:|--:|--:|", *rows, ""]


def form_factors(folder: Path) -> list[str]:
    """A section of the report: form factors of a closed scene, whose rows must sum to one exactly."""
    line = run(folder, "formfactors", "furnace:4", "-o", "furnace.npz", "--rays", "256x64")
    with np.load(folder / "furnace.npz") as stored:
        exact = (stored["row_sums"] == 1 << int(stored["weight_bits"])).sum()
        count, worst = stored["row_sums"].size, np.abs(sparse.load_npz(folder / "furnace.npz").sum(axis=1) - 1).max()
    return ["## Form factors of a closed cube", "", f"`{line}`", "",
            f"{exact} of {count} hemispheres sum to 1 exactly, as integers; the rows of F in floating point are within "
            f"{worst:.1e} of it.", ""]


def on_the_machine(folder: Path) -> list[str]:
    """A section of the report: an image whose hemispheres and primary rays the RTL has cast, beside golden's."""
    line = run(folder, "render", *RENDERED, *MACHINE, "-o", "machine.png", "-o", "machine.exr", "--stats",
               "machine.json")
    cast = run(folder, "cast", "cornell", "--patch", "4", "--cell", "0.25", *MACHINE, "--timeline", "timeline.svg")
    run(folder, "render", *RENDERED, "--method", "shelling", "-o", "machine-golden.png", "-o", "machine-golden.exr")
    for suffix in "png", "exr":
        if (folder / f"machine.{suffix}").read_bytes() != (folder / f"machine-golden.{suffix}").read_bytes():
            raise SystemExit(f"error: machine.{suffix} is not what golden makes")
    with Image.open(folder / "machine.png") as ours, Image.open(folder / "machine-golden.png") as theirs:
        ImageChops.difference(ours.convert("RGB"), theirs.convert("RGB")).save(folder / "machine-difference.png")
    done = json.loads((folder / "machine.json").read_text())["machine"]
    return ["## On the machine", "", f"`{line}`", "",
            "![the machine's image](machine.png) ![golden's](machine-golden.png) "
            "![the difference](machine-difference.png)", "",
            f"Hemispheres and primary rays were cast by the RTL, {done['share']:.1%} of all rays: {done['frusta']} "
            f"frusta in {done['jobs']} jobs, {done['rays']:,} rays, {done['cycles']:,} cycles in all, "
            f"{done['tested'] / done['rays']:.2f} tests per ray. All bytes of both images are golden's: the third one "
            "is black.", "",
            f"`{cast}`", "", "![what is busy when](timeline.svg)", ""]


def write_demo(folder: Path) -> Path:
    """Run all jobs in a folder and return the report's path.

    Raises
    ------
    click.exceptions.Exit
        A job fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    report = ["# Demo", "",
              f"{DISTRIBUTION} {package_version()}, Python {platform.python_version()}, "
              f"numpy {version('numpy')}, {processors()} cores ({platform.machine()}). The golden renderer "
              "makes all but the last picture in double precision.", ""]
    run(folder, "scene", "phone", "-o", "phone.glb")
    for job in RENDERS:
        report += picture(folder, *job)
    report += form_factors(folder)
    report += on_the_machine(folder)
    (folder / "report.md").write_text("\n".join(report))
    return folder / "report.md"
