"""A mapped module in Yosys' JSON format, with who drives and who reads each bit."""

from collections import defaultdict

__all__ = ["Netlist"]


class Netlist:
    """Cells, with the driver and the readers of each bit. Bits are numbers; constants are texts.

    Parameters
    ----------
    module
        Of a netlist in Yosys' JSON format. Changes of `cells` are changes of it.
    """

    def __init__(self, module: dict):
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
