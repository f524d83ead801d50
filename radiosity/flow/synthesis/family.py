"""Families of FPGAs: how Yosys maps to them, and how their cells are counted."""

import math
from dataclasses import dataclass

from golden.base.errors import InputError

__all__ = ["FAMILIES", "UNMAPPED", "Area", "Family"]


@dataclass(frozen=True, kw_only=True)
class Area:
    """Resources of an FPGA that a component uses, in units of its `Family`.

    Parameters
    ----------
    lut, ff, dsp, bram
        LUTs, in units of which adders and distributed memories are counted too; registers; DSP blocks; block RAMs.
    folded
        LUTs that adders absorbed: the mapper's netlist has as many more.
    """

    lut: int
    ff: int
    dsp: int
    bram: int
    folded: int = 0


@dataclass(frozen=True, kw_only=True)
class Family:
    """A family of FPGAs.

    Parameters
    ----------
    title
        What it is called.
    commands
        Of Yosys, that map a design ``top`` to its cells.
    lut, ff, dsp, bram
        By type, how many units a cell counts as.
    free
        Cells that are not counted: parts of a LUT's slice, constants, pins and clocks.
    counted
        The units in words.
    has_clock
        Whether there is a tool for place and route.
    """

    title: str
    commands: tuple[str, ...]
    lut: dict[str, int]
    ff: frozenset[str]
    dsp: dict[str, float]
    bram: dict[str, int]
    free: frozenset[str]
    counted: str
    has_clock: bool = False

    def area(self, cells: dict[str, int]) -> Area:
        """The area of a netlist, from its number of cells of each type.

        Raises
        ------
        InputError
            It is not known how a cell is counted.
        """
        for cell in cells:
            if not (cell in self.free or cell in self.ff or any(cell in takes for takes in (
                    self.lut, self.dsp, self.bram)) or cell == "$scopeinfo"):
                raise InputError(f"report: Cells for {self.title} must be of a type that is counted, not {cell}")

        def total(takes):
            return math.ceil(sum(count * takes.get(cell, 0) for cell, count in cells.items()))

        return Area(lut=total(self.lut), ff=total(_each(*self.ff)), dsp=total(self.dsp), bram=total(self.bram))


# The file with the names of the memories that no RAM of the family supports and that have more words than this. Smaller
# ones become registers.
UNMAPPED, _WORDS = "unmapped.memories", 128


def _map(mapper):
    """All that a command of Yosys does, unless a RAM is missing for a large memory."""
    unmapped = f"t:$mem_v2 r:SIZE>{_WORDS} %i"
    return (f"{mapper} -run begin:map_ffram", f"select -write {UNMAPPED} {unmapped}",
            f"select -assert-none {unmapped}", f"{mapper} -run map_ffram:")


def _each(*cells, takes=1):
    return dict.fromkeys(cells, takes)


FAMILIES = {
    "ecp5": Family(
        title="ECP5-85, speed grade 6", has_clock=True,
        # The registers of a tile share few enables and resets: one with few registers becomes logic in front of
        # them.
        commands=("synth_ecp5 -abc9 -top top -run begin:map_ffs",
                  "dfflegalize -cell $_DFF_?_ 01 -cell $_SDFF_?P?_ r -cell $_DFFE_??_ 01 -cell $_SDFFE_?P??_ r "
                  "-mince 8 -minsrst 16",
                  "synth_ecp5 -abc9 -top top -run map_ffs:"),
        lut={"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 6}, ff=frozenset({"TRELLIS_FF"}), dsp={"MULT18X18D": 1},
        bram={"DP16KD": 1},
        free=frozenset({"PFUMX", "L6MUX21", "TRELLIS_IO", "SGSR", "DCCA", "EHXPLLL", "ODDRX1F"}),
        counted="LUT: of 4 inputs, 2 for a two-bit adder, 6 for a memory of 16 x 4 bits; DSP: blocks of 18 x 18 bits; "
                "block RAMs of 18 kbit. FF: without the registers inside DSP blocks and block RAMs."),
    "xc7": Family(
        title="Xilinx 7 series", commands=_map("synth_xilinx -family xc7 -flatten -noiopad -noclkbuf -top top"),
        lut=_each(*(f"LUT{inputs}" for inputs in range(1, 7)), "SRL16E", "SRLC32E", "RAM32X1S", "RAM64X1S")
        | _each("RAM32X1D", "RAM64X1D", "RAM128X1S", takes=2)
        | _each("RAM32M", "RAM64M", "RAM128X1D", "RAM256X1S", takes=4),
        ff=frozenset({"FDRE", "FDSE", "FDCE", "FDPE"}), dsp={"DSP48E1": 1}, bram={"RAMB18E1": 1, "RAMB36E1": 2},
        free=frozenset({"CARRY4", "MUXF7", "MUXF8", "INV", "VCC", "GND"}),
        counted="LUT: of 6 inputs, shift registers, memories and adders included; DSP: DSP48E1; block RAMs of 18 kbit, "
                "a RAMB36E1 counts as two. FF: without the registers inside DSP blocks."),
    "gowin": Family(
        title="Gowin GW2A", commands=_map("synth_gowin -family gw2a -noiopads -top top"),
        lut=_each("LUT1", "LUT2", "LUT3", "LUT4", "ALU") | _each("RAM16SDP1", "RAM16SDP2", "RAM16SDP4", takes=6),
        ff=frozenset("DFF" + kind for kind in (
            "", "E", "S", "SE", "R", "RE", "P", "PE", "C", "CE")),
        # Two of 9 x 9 bits share the site of one of 18 x 18, and one of 36 x 36 uses four.
        dsp={"MULT9X9": 0.5, "MULT18X18": 1, "MULT36X36": 4},
        bram=_each("SP", "SPX9", "SDPB", "SDPX9B", "DPB", "DPX9B", "pROM", "pROMX9"),
        free=frozenset({"MUX2_LUT5", "MUX2_LUT6", "MUX2_LUT7", "MUX2_LUT8", "VCC", "GND"}),
        counted="LUT: of 4 inputs, 1 for an adder's bit, 6 for a memory of 16 x 4 bits; DSP: blocks of 18 x 18 bits; "
                "block RAMs of 18 kbit. FF: with the registers at DSP blocks."),
    "ice40": Family(
        title="iCE40 UltraPlus",
        # It has no distributed memories.
        commands=("setattr -unset ram_style m:*", *_map("synth_ice40 -device u -dsp -top top")),
        lut={"SB_LUT4": 1},
        ff=frozenset("SB_DFF" + kind for kind in ("", "E", "SR", "R", "SS", "S", "ESR", "ER", "ESS", "ES")),
        dsp={"SB_MAC16": 1}, bram={"SB_RAM40_4K": 1}, free=frozenset({"SB_CARRY", "VCC", "GND"}),
        counted="LUT: of 4 inputs, with the carry in the same cell; DSP: SB_MAC16 of 16 x 16 bits; block RAMs of 4 "
                "kbit. FF: with distributed memories, without the registers inside DSP blocks."),
}
