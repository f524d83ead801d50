"""The files beside an exported engine that a host needs: a driver and a simulation that uses it."""

from collections.abc import Mapping
from pathlib import Path

from golden.config import Config
from hw.package.software.driver_files import driver_files
from hw.package.software.sample_job import sample_job

__all__ = ["software_files"]

_FOLDER = Path(__file__).parent


def software_files(name: str, *, config: Config, counters: Mapping[str, str], sha256: str) -> dict[str, str | bytes]:
    """The contents of the files by their paths in the folder of the core.

    Parameters
    ----------
    name
        Of the engine's module.
    config
        The configuration.
    counters
        Names of the counters of a cluster in the order of their addresses, each with what it counts.
    sha256
        Of the engine's Verilog.
    """
    example = {file: (_FOLDER / f"{file}.in").read_text().replace("@NAME@", name) for file in ("main.cpp", "Makefile")}
    return {**{f"driver/{file}": text for file, text in driver_files(counters).items()},
            **{f"example/{file}": text for file, text in example.items()},
            **{f"job/{file}": data for file, data in sample_job(config, sha256=sha256).items()}}
