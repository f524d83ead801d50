"""The hardware as Verilog."""

import os
from collections.abc import Mapping
from pathlib import Path

from golden.base.errors import InputError, check_choice
from golden.engine.config import PRESETS
from radiosity.flow.package.core_files import write_core
from radiosity.flow.package.tops import TOPS

__all__ = ["export_verilog"]


def export_verilog(folder: str | os.PathLike[str], *, top: str = "engine", preset: str = "paper",
                   parameters: Mapping[str, int | str] | None = None, period: float | None = None,
                   ram_styles: bool = False) -> list[Path]:
    """Write a component as Verilog, with constraints, a description for FuseSoC, a manifest and a driver.

    Needs the extra ``sim``.

    Parameters
    ----------
    folder
        Where files go; it is made.
    top
        engine, async_engine, cluster, icu, ctu, router and others of `radiosity.flow.package.tops.TOPS`.
    preset, parameters
        The configuration: a preset, and values of parameters by path, such as ``{"icu.rays": 4096}``.
    period
        Nanoseconds of each clock in the constraints. Default: one that an ECP5-85 has reached.
    ram_styles
        Whether memories have the attribute ``ram_style``, which not all tools accept.

    Returns
    -------
    The paths.

    Raises
    ------
    InputError
        There is no such top, preset or parameter, or a value is out of range.
    """
    for name, value, known in (("top", top, TOPS), ("preset", preset, PRESETS)):
        check_choice(f"verilog: {name.capitalize()}", value, known, parameter=name)
    if period is not None and not 0.1 <= period < float("inf"):
        raise InputError(f"verilog: Period must be at least 0.1 ns, not {period!r}", parameter="period")
    config = PRESETS[preset].with_parameters(f"{path}={value}" for path, value in (parameters or {}).items())
    return write_core(top, config=config, preset=preset, folder=Path(folder), period=period, ram_styles=ram_styles)
