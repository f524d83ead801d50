"""The shell on a ULX3S with an ECP5-85."""

import json
import os
from dataclasses import asdict
from pathlib import Path

from amaranth.build import Platform
from amaranth.hdl import Elaboratable, Module
from amaranth.lib import io
from amaranth.lib.cdc import FFSynchronizer
from amaranth_boards.ulx3s import ULX3S_85F_Platform

from hw.board.board_shell import BoardShell
from radiosity.flow.output import write_text
from radiosity.flow.synthesis.flow import Bitstream, bitstream

__all__ = ["CLOCK_HZ", "NEXTPNR", "build"]

# The board's oscillator, the only clock.
CLOCK_HZ = 25_000_000
# Options of nextpnr. The FPGA is full and the clock slow: wirelength counts, timing does not.
NEXTPNR = ("--placer", "static", "--no-tmdriv", "--router", "router2")
NAME = "board"


class _Ulx3s(Elaboratable):
    """A component at the board's pins.

    The serial line is the one of the USB socket. Button F1 is ``again``, light 0 ``busy``, light 1 ``failed``.
    """

    def __init__(self, shell: BoardShell):
        self._shell = shell

    def elaborate(self, platform: Platform):
        m = Module()
        m.submodules.shell = shell = self._shell
        for name, pins, value in (("tx", platform.request("uart", 0, dir="-").tx, shell.tx),
                                  ("light_0", platform.request("led", 0, dir="-"), shell.busy),
                                  ("light_1", platform.request("led", 1, dir="-"), shell.failed)):
            m.submodules[name] = buffer = io.Buffer("o", pins)
            m.d.comb += buffer.o.eq(value)
        m.submodules.button = button = io.Buffer("i", platform.request("button_fire", 0, dir="-"))
        m.submodules.synchronizer = FFSynchronizer(button.i[0], shell.again)
        return m


def build(shell: BoardShell, folder: Path, *, seeds: tuple[int, ...],
          options: tuple[str, ...] = NEXTPNR) -> tuple[list[Path], Bitstream | None]:
    """Write Verilog and constraints, and with seeds the bitstream and its figures.

    Parameters
    ----------
    seeds, options
        Of the placer, which places once for each; options of nextpnr.

    Returns
    -------
    tuple
        The written files, and the figures.

    Raises
    ------
    InputError
        It does not fit.
    """
    os.environ["AMARANTH_USE_YOSYS"] = "builtin"
    files = ULX3S_85F_Platform().prepare(_Ulx3s(shell), "top", emit_src=False, debug_verilog=True).files
    constraints = files["top.lpf"]
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / f"{NAME}.v", folder / f"{NAME}.lpf"]
    for path, text in zip(written, (files["top.debug.v"], constraints), strict=True):
        write_text(path, text)
    figures = None
    if seeds:
        figures = bitstream(files["top.il"], constraints, folder, NAME, seeds=seeds, options=options)
        written += [folder / f"{NAME}.bit", folder / f"{NAME}.figures.json"]
        write_text(written[-1], json.dumps(asdict(figures), indent=1) + "\n")
    return written, figures
