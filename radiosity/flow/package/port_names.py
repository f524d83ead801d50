"""The names of an exported module's ports, legal in Verilog and VHDL."""

__all__ = ["port_name"]

# Prefixes by which Vivado and Quartus know a bus; tools that group ports by interface infer AXI from them.
_BUSES = {"axi": "m_axi", "host": "s_axil"}


def port_name(path: str) -> str:
    """The name of the port that a component has as ``path``, its members joined by two underscores.

    VHDL allows no two underscores in succession, and Verilator mangles them.
    """
    bus, *parts = path.split("__")
    return "_".join([_BUSES.get(bus, bus) if parts else bus, *parts])
