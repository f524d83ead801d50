"""The files beside an exported engine that a host needs: a driver, a simulation that uses it, and a LiteX module."""

from pathlib import Path

from golden.engine.config import Config
from radiosity.flow.package.software.driver_files import driver_files
from radiosity.flow.package.software.sample_job import sample_job
from radiosity.flow.simulator.verilator import OPTIMIZATION

__all__ = ["software_files"]

_FOLDER = Path(__file__).parent
# Paths in the folder of a core, with the files that they are made from.
_TEMPLATES = {
    **{f"example/{file}": f"{file}.in" for file in (
        "main.cpp", "cast_job.c", "cast_job.h", "decode.c", "decode.py", "Makefile")},
    **{f"litex_soc/{file}": f"{file}.in" for file in ("radiosity_soc.py", "simulation.py", "ulx3s.py", "uartbone.c")},
    "litex_soc/Makefile": "litex.mk.in",
}


def software_files(name: str, *, config: Config, sha256: str, buses: tuple[str, ...] = ()) -> dict[str, str | bytes]:
    """The contents of the files by their paths in the folder of the core.

    Parameters
    ----------
    name
        Of the engine's module.
    config
        The configuration.
    sha256
        Of the engine's Verilog.
    buses
        Those with a clock and a reset of their own; the simulation drives all clocks together.
    """
    words = {"@NAME@": name, "@OPTIMIZATION@": OPTIMIZATION, "@SHA256@": sha256,
             "@CLOCKS@": " = top.".join(["clk", *(f"{bus}_aclk" for bus in buses)]),
             "@RESETS@": "".join(f"        top.{bus}_aresetn = 1;\n" for bus in buses)}

    def filled(template):
        text = (_FOLDER / template).read_text()
        for word, value in words.items():
            text = text.replace(word, value)
        return text
    return {**{f"driver/{file}": text for file, text in driver_files().items()},
            **{path: filled(template) for path, template in _TEMPLATES.items()},
            **{f"job/{file}": data for file, data in sample_job(config, sha256=sha256).items()}}
