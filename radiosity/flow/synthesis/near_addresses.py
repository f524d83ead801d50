"""Distributed memories of fewer than 16 words: spare address bits become copies of one that is used.

A constant at a memory's pins comes from one site of the chip, and its routing takes longer than that of all other nets.
"""

from radiosity.flow.synthesis.netlist import MappedModule

__all__ = ["copy_addresses"]

_BITS, _WORDS, _WIDTH = 4, 16, 4


def copy_addresses(module: MappedModule) -> int:
    """Let address bits that are 0 for reading and writing be copies of the highest one that is not.

    Words and initial values move; the function of the module is the same.

    Returns
    -------
    int
        Number of pins that a net drives in place of a constant.
    """
    gone = 0
    for cell in module["cells"].values():
        if cell["type"] != "TRELLIS_DPR16X4":
            continue
        read, write = (cell["connections"][pin] for pin in ("RAD", "WAD"))
        spare = [k for k in range(_BITS) if read[k] == write[k] == "0"]
        used = [k for k in range(_BITS) if k not in spare]
        if not used:
            continue
        for k in spare:
            read[k], write[k] = read[used[-1]], write[used[-1]]
        cell["parameters"]["INITVAL"] = _moved(cell["parameters"]["INITVAL"], spare, used[-1])
        gone += 2 * len(spare)
    return gone


def _moved(values, spare, follows):
    """Initial values, the last word first, at the words' new addresses."""
    words = [values[first:first + _WIDTH] for first in range(0, _WORDS * _WIDTH, _WIDTH)][::-1]
    moved = ["x" * _WIDTH] * _WORDS
    for address, word in enumerate(words):
        if not any(address >> k & 1 for k in spare):
            moved[address | sum((address >> follows & 1) << k for k in spare)] = word
    return "".join(moved[::-1])
