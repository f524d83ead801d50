"""A mapped module in Yosys' JSON format, with who drives and who reads each bit."""

from collections import defaultdict

__all__ = ["MappedModule", "Netlist"]

# In Yosys' JSON format. What takes one changes it in place.
MappedModule = dict


class Netlist:
    """Cells, with the driver and the readers of each bit. Bits are numbers; constants are texts.

    Changes of `cells` are changes of the module.
    """

    def __init__(self, module: MappedModule):
        self.cells = module["cells"]
        # The name of a cell; names of cells and their pins, None and None for a port of the module.
        self.driver, self.readers = {}, defaultdict(set)
        for port in module["ports"].values():
            if port["direction"] == "output":
                for bit in port["bits"]:
                    self.readers[bit].add((None, None))
        for name, cell in self.cells.items():
            for pin, bits in cell["connections"].items():
                for bit in bits:
                    if cell["port_directions"][pin] == "output":
                        self.driver[bit] = name
                    else:
                        self.readers[bit].add((name, pin))
