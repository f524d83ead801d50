"""Registers with many readers have copies, each near its readers.

One register in the middle of the chip reaches readers all over it after most of a clock's period.
"""

from hw.synthesis.netlist import Netlist

__all__ = ["READERS", "copy_registers"]

# Readers of one copy. More copies take more registers, fewer take longer wires.
READERS = 96


def copy_registers(module: dict) -> int:
    """Give registers with more than `READERS` readers copies, which share them.

    Readers whose names follow each other, those of one unit, have the same copy. The port of a module and the global clock
    network keep the register itself. The function of the module is the same in every cycle.

    Parameters
    ----------
    module
        Of a netlist in Yosys' JSON format; changed in place.

    Returns
    -------
    int
        Number of registers that were added.
    """
    netlist, added = Netlist(module), 0
    free = 1 + max(bit for net in module["netnames"].values() for bit in net["bits"] if isinstance(bit, int))
    for name in [name for name, cell in netlist.cells.items() if cell["type"] == "TRELLIS_FF"]:
        register = netlist.cells[name]
        bit, = register["connections"]["Q"]
        readers = sorted((reader, pin) for reader, pin in netlist.readers[bit]
                         if reader is not None and netlist.cells[reader]["type"] != "DCCA")
        copies = -(-len(readers) // READERS)
        for number in range(1, copies):
            made = f"{name}_copy_{number}"
            netlist.cells[made] = {**register, "connections": {**register["connections"], "Q": [free]}}
            module["netnames"][made] = {"hide_name": 0, "bits": [free], "attributes": {}}
            for reader, pin in readers[len(readers) * number // copies:len(readers) * (number + 1) // copies]:
                bits = netlist.cells[reader]["connections"][pin]
                netlist.cells[reader]["connections"][pin] = [free if found == bit else found for found in bits]
            free, added = free + 1, added + 1
    return added
