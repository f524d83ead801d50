"""Registers and LUTs with many readers have copies, each near its readers.

One driver in the middle of the chip reaches readers all over it after most of a clock's period. Multipliers lie in few
rows of the chip, so those of one operand are far apart.
"""

from radiosity.flow.synthesis.netlist import MappedModule, Netlist

__all__ = ["MOST_FAN_OUT", "MOST_MULTIPLIERS", "copy_drivers"]

# A copy for so many readers, or for so many multipliers among them. More copies take more area, with fewer the nets are
# longer.
MOST_FAN_OUT, MOST_MULTIPLIERS = 96, 4
# Copies of LUTs come first: they are readers of the registers. With each type the pin of its output.
_DRIVERS = (("LUT4", "Z"), ("TRELLIS_FF", "Q"))
# The inputs of a multiplexer are the LUTs of its own slice.
_FIXED = ("ALUT", "BLUT")


def copy_drivers(module: MappedModule) -> dict[str, int]:
    """Give registers and LUTs with more than `MOST_FAN_OUT` readers or `MOST_MULTIPLIERS` copies, which share them.

    Readers whose names follow each other, those of one unit, have the same copy. Ports of the module, the global clock
    network, and multiplexers of LUTs keep the driver itself. The function of the module is the same in every cycle.

    Returns
    -------
    dict
        Number of copies by the type of their cells.
    """
    free = 1 + max(bit for net in module["netnames"].values() for bit in net["bits"] if isinstance(bit, int))
    added = {}
    for kind, output in _DRIVERS:
        netlist = Netlist(module)
        drivers = [name for name, cell in netlist.cells.items() if cell["type"] == kind]
        made = 0
        for name in drivers:
            driver = netlist.cells[name]
            bit, = driver["connections"][output]
            readers = sorted(
                (reader, pin) for reader, pin in netlist.readers[bit]
                if reader is not None and netlist.cells[reader]["type"] != "DCCA" and pin not in _FIXED)
            multipliers = {reader for reader, _ in readers if netlist.cells[reader]["type"] == "MULT18X18D"}
            copies = max(-(-len(readers) // MOST_FAN_OUT), -(-len(multipliers) // MOST_MULTIPLIERS))
            for number in range(1, copies):
                cell = f"{name}_copy_{number}"
                netlist.cells[cell] = {**driver, "connections": {**driver["connections"], output: [free]}}
                module["netnames"][cell] = {"hide_name": 0, "bits": [free], "attributes": {}}
                for reader, pin in readers[len(readers) * number // copies:len(readers) * (number + 1) // copies]:
                    bits = netlist.cells[reader]["connections"][pin]
                    netlist.cells[reader]["connections"][pin] = [free if found == bit else found for found in bits]
                free, made = free + 1, made + 1
        added[kind] = made
    return added
