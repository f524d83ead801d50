"""An exported engine in a SoC of LiteX on a ULX3S with an ECP5-85, with the board's SDRAM."""

import json
import os
import subprocess
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import asdict
from pathlib import Path

from golden.base.errors import InputError
from golden.engine.config import PRESETS, Config
from radiosity.flow.output import write_text
from radiosity.flow.package.core_files import write_core
from radiosity.flow.synthesis.flow import check_options, verilog_bitstream

__all__ = ["NEXTPNR", "PRESET", "SOC", "build_soc"]

PRESET, NAME = "small", "soc"
# Options of nextpnr. The wires of the slow clock take most of its period, so timing counts in the placement too.
NEXTPNR = ("--placer", "static", "--router", "router2")
# One cluster with one traversal pipeline that fits an ECP5-85, and narrow numbers: of the lengths in a room of 8 m, 18
# bits are steps of 0.03 mm. tb/radiosity/flow/board/test_soc.py compares the hits with float64.
# 1024 rays and the capacities of the preset for scenes like `room1627`, with 512 resident patches, in 32 MB of SDRAM.
# Hits have no (u, v), which form factors do not need. Caches of 256 lines are in block RAM, those of 128 in LUTs.
# An exported engine has all cache policies. Jobs use direct placement here, so the others have few lines and ways.
SOC = PRESETS[PRESET].replace({
    "numbers.scene_bits": 18, "numbers.vector_fraction": 16, "numbers.vertex_bits": 15, "numbers.mantissa_bits": 18,
    "numbers.direction_fraction": 14, "numbers.fraction_bits": 14,
    "icu.angle_bits": 18, "icu.cordic_stages": 12, "icu.cordic_guard": 4,
    "icu.rays": 1024, "icu.patch_bits": 11, "icu.slots": 16, "icu.generation_bits": 2, "icu.product_registers": 1,
    "icu.uv_bits": 0, "icu.uv_guard": 0, "ctu.pipelines": 1, "noc.columns": 1, "noc.rows": 1,
    "memsys.cache_policy": "direct", "memsys.cell_lines": 256, "memsys.patch_lines": 256, "memsys.lfu_lines": 2,
    "memsys.cache_ways": 2, "memsys.cache_fetches": 4, "memsys.scene_cells": 4096, "memsys.own_cells": 1024,
    "memsys.own_entries": 4096, "memsys.store_patches": 0, "memory.address_bits": 25, "memory.outstanding": 8})


def build_soc(config: Config, folder: Path, *, litex: Path, hertz: int, baud: int, revision: str, seed: int,
              options: tuple[str, ...], stage: Callable[[str], AbstractContextManager], routes: bool = True) -> dict:
    """Export an engine and make a SoC around it, and with ``routes`` the bitstream and its figures.

    Parameters
    ----------
    config
        The engine.
    folder
        For the exported engine. LiteX's files are in its ``litex_soc/ulx3s/``.
    litex
        The Python that has LiteX.
    hertz, baud, revision
        The clock of the SoC, the rate of its serial line, and the revision of the board.
    seed, options
        Of the placer; options of nextpnr.
    stage
        Begins a stage of the work: ``export``, ``LiteX`` or ``synthesis, place and route``.

    Returns
    -------
    dict
        ``output``, the files in the order in which they are written; with ``routes`` also ``seconds`` for all stages,
        and the figures.

    Raises
    ------
    InputError
        There is no such LiteX, nextpnr refuses an option, the SoC does not fit, or it misses its clock.
    """
    begin = time.perf_counter()
    if config.noc.nodes != 1:
        raise InputError(f"soc: Clusters (noc.columns, noc.rows) must be 1, not {config.noc.nodes}")
    options = "--freq", f"{hertz / 1e6:g}", *options
    if routes:
        check_options(options, has_constraints=True)
    _run_litex(litex, "-c", "import litedram, litex_boards.platforms.radiona_ulx3s", folder=Path.cwd())
    with stage("export"):
        write_core("engine", config=config, preset=PRESET, folder=folder, ram_styles=True)
    made = folder / "litex_soc" / "ulx3s"
    with stage("LiteX"):
        _run_litex(litex, "ulx3s.py", made.name, "--clock", str(hertz), "--baud", str(baud), "--revision", revision,
                   folder=made.parent)
    sources = folder / "radiosity_engine.sv", made / "gateware" / "top.v"
    constraints = made / "gateware" / "top.lpf"
    facts = {"output": [str(path) for path in (*sources, constraints)]}
    if routes:
        with stage("synthesis, place and route"):
            result = verilog_bitstream(sources, constraints.read_text(), made, NAME, seeds=(seed,), options=options)
        facts |= {"seconds": round(time.perf_counter() - begin)} | asdict(result.area) | asdict(result.clocks[0])
        figures = made / f"{NAME}.figures.json"
        facts["output"] += [str(made / f"{NAME}.bit"), str(figures)]
        write_text(figures, json.dumps({name: facts[name] for name in facts if name != "output"}, indent=1) + "\n")
    return facts


def _run_litex(python, *arguments, folder):
    # Nothing of this environment's packages: LiteX's is another one.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    try:
        done = subprocess.run([python, *arguments], cwd=folder, env=environment, capture_output=True, text=True,
                              check=False)
    except OSError:
        raise InputError(f"soc: there is no {python}; in a checkout `make litex` installs LiteX, --litex names another "
                         "Python that has it") from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line] or [f"exit code {done.returncode}"]
        raise InputError(f"soc: LiteX failed: {lines[-1]}")
