"""High-fanout enables and resets use the global clock network.

There they add no congestion, and their registers may be placed anywhere.
"""

from collections import defaultdict

from radiosity.flow.synthesis.netlist import MappedModule

__all__ = ["globalise"]

# The network has eight signals for pins that are no clocks, and one is the clock's. Nets with fewer sinks are routed
# without trouble.
NETS, LEAST_FAN_OUT = 7, 800
PINS = ("CE", "LSR")
# Beside the buffers in the middle of an ECP5-85's left edge: nextpnr chooses the buffer that is nearest to a register
# with a place, and routes the net between them first, by the number of its switches, not by their delay.
_ANCHORS = tuple(f"X6/Y{45 - number}/SLICEA.FF0" for number in range(NETS))


def globalise(module: MappedModule) -> list[str]:
    """Give the signals that enable or reset the most registers a clock buffer (``DCCA``) to these pins.

    Their other sinks stay. Where the signal comes from a register behind another one, as of a reset, a copy of the
    register drives the buffer from beside it, and the net between both registers has the delay of the distance. The
    function of the module is the same.

    Returns
    -------
    list
        The buffers' names, the one with the most registers first: `NETS` at most, each with `LEAST_FAN_OUT` at least.
    """
    cells = module["cells"]
    readers, registers = defaultdict(list), {}
    for name, cell in cells.items():
        if cell["type"] == "TRELLIS_FF":
            registers[cell["connections"]["Q"][0]] = name
            for pin in PINS:
                for bit in cell["connections"].get(pin, []):
                    # Constants are texts.
                    if isinstance(bit, int):
                        readers[bit].append((cell, pin))
    free = 1 + max(bit for net in module["netnames"].values() for bit in net["bits"] if isinstance(bit, int))
    made = []
    # Of equally many the one with the lower number: the same netlist gives the same buffers.
    for bit in sorted(readers, key=lambda bit: (-len(readers[bit]), bit))[:NETS]:
        if len(readers[bit]) < LEAST_FAN_OUT:
            break
        source = bit
        register = cells.get(registers.get(bit))
        if register and register["connections"]["DI"][0] in registers:
            anchored = f"{registers[bit]}_at_buffer"
            cells[anchored] = {**register, "attributes": {**register["attributes"], "BEL": _ANCHORS[len(made)]},
                               "connections": {**register["connections"], "Q": [free]}}
            module["netnames"][anchored] = {"hide_name": 0, "bits": [free], "attributes": {}}
            source, free = free, free + 1
        made.append(f"global_{len(made)}")
        module["netnames"][made[-1]] = {"hide_name": 0, "bits": [free], "attributes": {}}
        cells[made[-1]] = {
            "hide_name": 0, "type": "DCCA", "parameters": {}, "attributes": {},
            "port_directions": {"CLKI": "input", "CLKO": "output"}, "connections": {"CLKI": [source], "CLKO": [free]}}
        for cell, pin in readers[bit]:
            cell["connections"][pin] = [free]
        free += 1
    return made
