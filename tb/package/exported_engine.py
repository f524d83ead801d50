"""Small engines that tests export, and the Makefiles beside them."""

import os
import subprocess

import pytest

from golden.config import PRESETS
from hw.simulator.verilator import verilator_package

__all__ = ["CONFIG", "MANIFESTS", "NAME", "WIDE", "make"]

NAME = "radiosity_engine"
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
