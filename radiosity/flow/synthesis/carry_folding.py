"""LUTs in front of adders become part of the adders' own LUTs, of which the mapper for the ECP5 uses two inputs."""

from itertools import chain, permutations, product

from radiosity.flow.synthesis.netlist import MappedModule, Netlist

__all__ = ["fold"]

_PINS = "ABCD"
_LUT_PINS = 4


def fold(module: MappedModule) -> int:
    """Fold each LUT that carry cells alone read into the LUTs of these cells, where all of them have inputs left.

    Half of a carry cell (``CCU2C``) has a LUT p of four inputs, and a table g of its inputs A and B, which are the
    first four entries of the same LUT. Its sum is p xor carry; its carry output is the carry where p is 1, g where p
    is 0. A fold composes p and g with the LUT in front. It holds if one assignment of nets to inputs has the same p
    for all values of the nets, and the same g wherever p is 0: this is decided by all values, so each fold is proved.
    The function of the module is the same.

    Returns
    -------
    int
        Number of LUTs that are gone.
    """
    netlist = _Netlist(module)
    # A folded LUT exposes the LUTs in front of it.
    pending, gone = list(netlist.luts()), 0
    while pending:
        name = pending.pop()
        if name in netlist.cells and (halves := netlist.carry_readers(name)):
            changes = [_composed(netlist, half, name) for half in halves]
            if None not in changes:
                for half, change in zip(halves, changes, strict=True):
                    netlist.replace(half, change)
                pending += netlist.remove(name)
                gone += 1
    return gone


class _Netlist(Netlist):
    """LUTs, and the halves of carry cells."""

    def luts(self):
        """Names of all LUTs."""
        return (name for name, cell in self.cells.items() if cell["type"] == "LUT4")

    def inputs(self, name, half=""):
        """The nets at the inputs of a LUT, or of a carry cell's half; constants are texts."""
        return [self.cells[name]["connections"][pin + half][0] for pin in _PINS]

    def carry_readers(self, name):
        """The halves of carry cells that read a LUT, as names and numbers; none if something else reads it."""
        halves = set()
        for reader, pin in self.readers[self.cells[name]["connections"]["Z"][0]]:
            # Not the carry input.
            if reader is None or self.cells[reader]["type"] != "CCU2C" or pin == "CIN":
                return []
            half = pin[1]
            if self.cells[reader]["parameters"][f"INJECT1_{half}"] != "NO":
                return []
            halves.add((reader, half))
        return sorted(halves)

    def replace(self, at, change):
        """Give a carry cell's half other nets and another table."""
        (name, half), (nets, table) = at, change
        for pin, net in zip(_PINS, nets, strict=True):
            self.readers[self.cells[name]["connections"][pin + half][0]].discard((name, pin + half))
            self.cells[name]["connections"][pin + half] = [net]
            self.readers[net].add((name, pin + half))
        self.cells[name]["parameters"][f"INIT{half}"] = f"{table:016b}"

    def remove(self, name):
        """Delete a LUT without readers; the LUTs in front of it."""
        for pin, net in zip(_PINS, self.inputs(name), strict=True):
            self.readers[net].discard((name, pin))
        before = {self.driver.get(net) for net in self.inputs(name)}
        del self.cells[name]
        return sorted(driver for driver in before if driver in self.cells and self.cells[driver]["type"] == "LUT4")


def _composed(netlist, at, lut):
    """Nets and table of a carry cell's half with a LUT folded into it, or None where there are none."""
    name, half = at
    output = netlist.cells[lut]["connections"]["Z"][0]
    inputs = chain(netlist.inputs(name, half), netlist.inputs(lut))
    nets = list(dict.fromkeys(net for net in inputs if isinstance(net, int) and net != output))
    if len(nets) > _LUT_PINS:
        return None
    table, front = (int(netlist.cells[cell]["parameters"][key], 2)
                    for cell, key in ((name, f"INIT{half}"), (lut, "INIT")))
    rows = []
    for values in product((0, 1), repeat=len(nets)):
        value = {"0": 0, "1": 1, "x": 0, **dict(zip(nets, values, strict=True))}
        value[output] = front >> _index(value[net] for net in netlist.inputs(lut)) & 1
        at_pins = _index(value[net] for net in netlist.inputs(name, half))
        rows.append((values, table >> at_pins & 1, table >> (at_pins & 3) & 1))
    spare = ["1"] * (_LUT_PINS - len(nets))
    for order in permutations(range(_LUT_PINS)):
        # `order[k]` is the input of net k; the inputs left are 1, so that g has entries of its own.
        if list(order[len(nets):]) != sorted(order[len(nets):]):
            continue
        found = _table(rows, order)
        if found is not None:
            pins = dict(zip(order, nets + spare, strict=True))
            return [pins[k] for k in range(_LUT_PINS)], found
    return None


def _table(rows, order):
    """The table of a half whose nets are at the inputs ``order``, or None where p and g exclude each other."""
    entries = {}
    for values, p, g in rows:
        pins = [1] * _LUT_PINS
        for k, value in zip(order, values, strict=False):
            pins[k] = value
        required = [(_index(pins), p)]
        if not p:
            required.append((_index(pins[:2]), g))
        for entry, value in required:
            if entries.setdefault(entry, value) != value:
                return None
    return sum(value << entry for entry, value in entries.items())


def _index(values):
    return sum(value << k for k, value in enumerate(values))
