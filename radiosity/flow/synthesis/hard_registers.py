"""Registers at DSP blocks and block RAMs become their internal ones, which the mapper for the ECP5 leaves unused."""

from radiosity.flow.synthesis.netlist import MappedModule, Netlist

__all__ = ["absorb"]

_OPERANDS = [f"{operand}{k}" for operand in "AB" for k in range(18)]
_PRODUCT = [f"P{k}" for k in range(36)]


def absorb(module: MappedModule) -> dict[str, int]:
    """Move registers into a mapped module's DSP blocks and block RAMs.

    The operands of a DSP block are registered inside if registers without reset hold both; its product, and the data of
    a block RAM's port, if such registers are the only sinks: a word of 36 bits as a whole. All registers of one
    DSP block share one enable. A register with other sinks stays for those. The function of the module is the same
    in every cycle.

    Returns
    -------
    dict
        Number of registers that were moved, by where: ``operand``, ``product``, ``block RAM``.
    """
    netlist = _Netlist(module)
    gone = {"operand": 0, "product": 0, "block RAM": 0}
    for name, cell in list(module["cells"].items()):
        if cell["type"] == "MULT18X18D":
            gone["product"] += _product(netlist, name)
            gone["operand"] += _operands(netlist, name)
        elif cell["type"] == "DP16KD":
            # Words of 36 bits come out at both ports' pins, and one register mode holds for all of them.
            is_wide = int(cell["parameters"]["DATA_WIDTH_B"], 2) == 36
            gone["block RAM"] += sum(_data(netlist, name, ports) for ports in (("BA",) if is_wide else ("A", "B")))
    return gone


class _Netlist(Netlist):
    """Registers that can be moved are those that start at 0 and have no reset."""

    def bit(self, name, pin):
        """What is connected to a pin."""
        return self.cells[name]["connections"][pin][0]

    def before(self, name, pin):
        """The register that drives an input pin, or None if it is none that can be moved."""
        register = self.driver.get(self.bit(name, pin))
        return register if register is not None and self._is_movable(register) else None

    def behind(self, name, pins):
        """By used output pin its register; none at all if a pin has another sink."""
        registers = {}
        for pin in pins:
            readers = self.readers[self.bit(name, pin)]
            if readers:
                (register, input_pin), *others = readers
                if others or input_pin != "DI" or not self._is_movable(register):
                    return {}
                registers[pin] = register
        return registers

    def control(self, register):
        """Its clock and its enable: "1" where it has none."""
        has_enable = self.cells[register]["parameters"]["CEMUX"].strip() == "CE"
        return self.bit(register, "CLK"), self.bit(register, "CE") if has_enable else "1"

    def add_input(self, name, pin, bit):
        """Connect an input pin that was not."""
        self.cells[name]["connections"][pin] = [bit]
        self.cells[name]["port_directions"][pin] = "input"

    def pass_by(self, name, registers):
        """Connect input pins to the inputs of the registers in front of them; how many registers have no sink then."""
        for pin, register in registers.items():
            self.readers[self.bit(name, pin)].remove((name, pin))
            self.cells[name]["connections"][pin] = [self.bit(register, "DI")]
            self.readers[self.bit(register, "DI")].add((name, pin))
        unread = [register for register in set(registers.values()) if not self.readers[self.bit(register, "Q")]]
        for register in unread:
            self.readers[self.bit(register, "DI")].remove((register, "DI"))
            del self.cells[register]
        return len(unread)

    def take_over(self, name, registers):
        """Let output pins drive what the registers behind them drive; how many registers are gone."""
        for pin, register in registers.items():
            bit = self.bit(register, "Q")
            self.cells[name]["connections"][pin], self.driver[bit] = [bit], name
            del self.cells[register]
        return len(registers)

    def _is_movable(self, name):
        cell = self.cells.get(name, {"type": None})
        return (cell["type"] == "TRELLIS_FF" and cell["connections"].get("LSR", ["0"]) == ["0"]
                and cell["parameters"]["REGSET"] == "RESET" and cell["parameters"]["CLKMUX"] == "CLK"
                and cell["parameters"]["CEMUX"].strip() in ("1", "CE"))


def _operands(netlist, name):
    # A register of a constant 1 would be 0 at first.
    registers = {pin: netlist.before(name, pin) for pin in _OPERANDS if netlist.bit(name, pin) != "0"}
    if not _share_control(netlist, name, registers.values()):
        return 0
    netlist.cells[name]["parameters"] |= {"REG_INPUTA_CLK": "CLK0", "REG_INPUTB_CLK": "CLK0"}
    return netlist.pass_by(name, registers)


def _product(netlist, name):
    registers = netlist.behind(name, _PRODUCT)
    if not _share_control(netlist, name, registers.values()):
        return 0
    netlist.cells[name]["parameters"]["REG_OUTPUT_CLK"] = "CLK0"
    return netlist.take_over(name, registers)


def _data(netlist, name, ports):
    """Of pins of ports at which words come out; the first one is that which is read."""
    registers = netlist.behind(name, [f"DO{port}{k}" for port in ports for k in range(18)])
    controls = {netlist.control(register) for register in registers.values()}
    if len(controls) != 1 or netlist.bit(name, f"RST{ports[0]}") != "0":
        return 0
    clock, enable = controls.pop()
    used = sorted({ports[0], *(pin[2] for pin in registers)})
    if any(netlist.bit(name, f"CLK{port}") != clock for port in used):
        return 0
    for port in used:
        netlist.add_input(name, f"OCE{port}", enable)
        netlist.cells[name]["parameters"][f"REGMODE_{port}"] = "OUTREG"
    return netlist.take_over(name, registers)


def _share_control(netlist, name, registers):
    """Whether there are registers with one clock and one enable, those of the ones inside already; connects them."""
    if not registers or None in registers:
        return False
    controls = {netlist.control(register) for register in registers}
    if "CLK0" in netlist.cells[name]["connections"]:
        controls.add((netlist.bit(name, "CLK0"), netlist.bit(name, "CE0")))
    if len(controls) != 1:
        return False
    for pin, bit in zip(("CLK0", "CE0", "RST0"), (*controls.pop(), "0"), strict=True):
        netlist.add_input(name, pin, bit)
    return True
