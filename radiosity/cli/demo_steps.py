"""The whole main job at a small size: a picture, the same rays on the simulated hardware, its Verilog, form factors."""

import csv
import platform
import subprocess
from html import escape
from importlib.metadata import version
from pathlib import Path

import click
import numpy as np
from scipy import sparse

from golden.base.output import whole_file
from golden.base.package_version import DISTRIBUTION, package_version
from golden.base.processors import processors
from radiosity.cli.console import console
from radiosity.cli.run import run
from radiosity.flow.simulator.verilator import verilator_package

__all__ = ["write_demo"]

# The picture, and a hemisphere in its room, which one cast finds in numpy and the other in the RTL of four clusters.
PICTURE = ("render", "cornell", "--method", "shelling", "--size", "160x160", "--spp", "1", "--rays", "32x8",
           "--max-edge", "150")
HEMISPHERE = ("cast", "cornell", "--patch", "4", "--cell", "0.25", "--clusters", "4")
# Arrays of a hit; the hardware's and golden's are compared bit for bit.
HIT = ("patch", "inverse", "u", "v")
HEAD = """<!doctype html>
<meta charset='utf-8'>
<title>Radiosity Engine</title>
<style>body{max-width:50em;margin:2em auto;font:16px/1.5 sans-serif} img{max-width:100%}</style>
<h1>Radiosity Engine</h1>"""


def write_demo(folder: Path) -> Path:
    """Run all commands in a folder and return the path of the page that shows them with what they made.

    Raises
    ------
    click.exceptions.Exit
        A command fails.
    click.ClickException
        The hardware's hits are not golden's.
    """
    folder.mkdir(parents=True, exist_ok=True)
    body = [_picture(folder), _hemisphere(folder), _verilog(folder), _form_factors(folder)]
    about = (f"{DISTRIBUTION} {package_version()}, Python {platform.python_version()}, numpy {version('numpy')}, "
             f"{processors()} cores ({platform.machine()}).")
    page = folder / "index.html"
    with whole_file(page) as part:
        part.write_text("\n".join((HEAD, f"<p>{escape(about)}</p>", *body, "")))
    return page


def _section(title, lines, text, picture=""):
    """A heading, the commands, what they show, and a picture by its name."""
    commands = "\n".join(f"<pre><code>{escape(line)}</code></pre>" for line in lines)
    image = f"\n<p><img src='{picture}' alt='{escape(title)}'></p>" if picture else ""
    return f"<h2>{escape(title)}</h2>\n{commands}\n<p>{escape(text)}</p>{image}"


def _picture(folder):
    line = run(folder, *PICTURE, "-o", "cornell.png")
    return _section("A picture by the golden model", [line], "The golden model in numpy cast the hemispheres of the "
                    "elements and the rays of the pixels, in the machine's integers.", "cornell.png")


def _hemisphere(folder):
    golden = run(folder, *HEMISPHERE, "-o", "golden.npz", "--compare", "naive,oracle")
    machine = run(folder, *HEMISPHERE, "--method", "machine", "-o", "machine.npz", "--csv", "counters.csv",
                  "--timeline", "timeline.svg", "--picture", "machine.png")
    with np.load(folder / "golden.npz") as ours, np.load(folder / "machine.npz") as theirs:
        different = sum(np.any([ours[name] != theirs[name] for name in HIT], axis=0))
        rays = ours["patch"].size
    if different:
        raise click.ClickException(f"demo: {different} of {rays} hits of the hardware are not golden's")
    cycles = _cycles(folder / "counters.csv")
    return _section("The same hemisphere on the simulated hardware", [golden, machine],
                    f"{different} of {rays:,} hits differ, in any bit. Four clusters took {cycles:,} cycles, "
                    f"{rays / cycles:.2f} rays per cycle. The chart shows what was busy when.", "timeline.svg")


def _cycles(counters):
    """Cycles of the last cast, of all clusters."""
    with counters.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return int(rows[-1]["cast_cycles"])


def _verilog(folder):
    line = run(folder, "verilog", "--preset", "tiny", "-o", "verilog")
    lint = ("verilator", "--lint-only", "-Wall", "--top-module", "radiosity_engine", "radiosity_engine.vlt",
            "radiosity_engine.sv")
    program = verilator_package() / "bin" / lint[0]
    text = " ".join(lint)
    if not console().quiet:
        click.echo(f"\n$ {text}", err=console().as_json)
    done = subprocess.run([program, *lint[1:]], cwd=folder / "verilog", check=False)
    if done.returncode:
        raise click.exceptions.Exit(done.returncode)
    count = (folder / "verilog" / "radiosity_engine.sv").read_text().count("\n")
    return _section("The engine as Verilog", [line, text],
                    f"{count:,} lines; Verilator has no remark. The folder has the driver in C, an example, and "
                    f"constraints.")


def _form_factors(folder):
    cube = run(folder, "formfactors", "furnace:4", "-o", "furnace.npz", "--rays", "64x16")
    hall = run(folder, "formfactors", "lobby", "-o", "lobby.npz")
    with np.load(folder / "furnace.npz") as stored:
        exact = (stored["row_sums"] == 1 << int(stored["weight_bits"])).sum()
        count = stored["row_sums"].size
    F = sparse.load_npz(folder / "lobby.npz")
    with np.load(folder / "lobby.npz") as stored:
        others = stored["sky"] + stored["back"]
    closure = np.abs(F.sum(axis=1) + others - 1).max()
    return _section("Form factors", [cube, hall], f"In a closed cube {exact} of {count} hemispheres sum to 1 exactly, "
                    f"as integers. In a hall of {F.shape[0]} patches each row, its share of the sky and of backs "
                    f"included, sums to 1 within {closure:.1e}.")
