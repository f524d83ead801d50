"""Registers inside multipliers and block RAMs: the netlist does the same with them as without."""

import copy
import json
import random

import pytest
from amaranth.hdl import Cat, Const, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.hard_registers import absorb

OPERAND, DEPTH, WIDTH = 17, 512, 18


class Registered(wiring.Component):
    """Products and a memory with registers, of which one is read elsewhere and one has a reset."""

    def __init__(self):
        super().__init__({
            "enable": In(1), "a": In(signed(OPERAND)), "b": In(signed(OPERAND)), "address": In(range(DEPTH)),
            "write": In(1), "o_operand": Out(signed(OPERAND)), "o_held": Out(signed(2 * OPERAND)),
            "o_free": Out(signed(2 * OPERAND)), "o_reset": Out(signed(2 * OPERAND)), "o_word": Out(WIDTH)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=DEPTH, init=[], attrs={"no_rw_check": 1})
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [write.en.eq(self.write), write.addr.eq(self.address), write.data.eq(self.a),
                     read.addr.eq(self.address)]
        a, b, c, d = (Signal(signed(OPERAND), name=name, reset_less=True) for name in "abcd")
        held, free = (Signal(signed(2 * OPERAND), name=name, reset_less=True) for name in ("held", "free"))
        word = Signal(WIDTH, reset_less=True)
        with m.If(self.enable):
            m.d.sync += [a.eq(self.a), b.eq(self.b), held.eq(a * b), word.eq(read.data)]
        m.d.sync += [c.eq(self.a), d.eq(self.b), free.eq(c * d), self.o_reset.eq(self.a * d)]
        m.d.comb += [self.o_operand.eq(a), self.o_held.eq(held), self.o_free.eq(free), self.o_word.eq(word)]
        return m


@pytest.fixture(scope="module")
def netlist(tmp_path_factory):
    """Mapped, with all registers in the fabric."""
    folder = tmp_path_factory.mktemp("netlist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flow, "absorb", lambda module: None)
        flow.synthesise(Registered(), folder)
    return json.loads((folder / "area.json").read_text())["modules"]["top"]


def test_registers_move_where_they_may(netlist):
    before = sum(cell["type"] == "TRELLIS_FF" for cell in netlist["cells"].values())
    module = copy.deepcopy(netlist)
    gone = absorb(module)
    # Of the operands one is read elsewhere, and `d` by the product whose other operand has no register.
    assert gone == {"operand": 2 * OPERAND, "product": 4 * OPERAND, "block RAM": WIDTH}
    assert sum(cell["type"] == "TRELLIS_FF" for cell in module["cells"].values()) == before - sum(gone.values())


class Wide(wiring.Component):
    """Words of 36 bits, with registers at all bits or at half of them."""

    def __init__(self, *, whole):
        self._whole = whole
        super().__init__({"address": In(range(DEPTH)), "write": In(1), "data": In(2 * WIDTH), "o": Out(2 * WIDTH)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=2 * WIDTH, depth=DEPTH, init=[], attrs={"no_rw_check": 1})
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [write.en.eq(self.write), write.addr.eq(self.address), write.data.eq(self.data),
                     read.addr.eq(self.address)]
        word = Signal(2 * WIDTH, reset_less=True)
        m.d.sync += word.eq(read.data)
        m.d.comb += self.o.eq(word if self._whole else Cat(read.data[:WIDTH], word[WIDTH:]))
        return m


class Odd(wiring.Component):
    """A product of registers with a constant 1 below each: 1 at first."""

    def __init__(self):
        super().__init__({"a": In(OPERAND - 1), "b": In(OPERAND - 1), "o": Out(signed(2 * OPERAND))})

    def elaborate(self, platform):
        m = Module()
        a, b = (Signal(OPERAND - 1, name=name, reset_less=True) for name in "ab")
        m.d.sync += [a.eq(self.a), b.eq(self.b)]
        m.d.comb += self.o.eq(Cat(Const(1, 1), a).as_signed() * Cat(Const(1, 1), b).as_signed())
        return m


def test_registers_beside_a_constant_1_stay(tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flow, "absorb", lambda module: None)
        flow.synthesise(Odd(), tmp_path)
    module = json.loads((tmp_path / "area.json").read_text())["modules"]["top"]
    before = copy.deepcopy(module)
    assert [cell["type"] for cell in module["cells"].values()].count("MULT18X18D") == 1
    assert absorb(module) == {"operand": 0, "product": 0, "block RAM": 0}
    assert next(_run(module, 1)) == next(_run(before, 1)) == [1] + [0] * (2 * OPERAND - 1)


@pytest.mark.parametrize("whole", [False, True])
def test_a_wide_word_moves_as_a_whole_or_not_at_all(whole, tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flow, "absorb", lambda module: None)
        flow.synthesise(Wide(whole=whole), tmp_path)
    module = json.loads((tmp_path / "area.json").read_text())["modules"]["top"]
    assert absorb(module)["block RAM"] == (2 * WIDTH if whole else 0)
    memory, = (cell["parameters"] for cell in module["cells"].values() if cell["type"] == "DP16KD")
    assert int(memory["DATA_WIDTH_B"], 2) == 2 * WIDTH
    assert [memory[f"REGMODE_{port}"] for port in "AB"] == 2 * ["OUTREG" if whole else "NOREG"]


def _cells(module, kind):
    return [cell for cell in module["cells"].values() if cell["type"] == kind]


def _held(module):
    """The registers with an enable that a product drives, and the net of its lowest bit."""
    for product in _cells(module, "MULT18X18D"):
        nets = [product["connections"][f"P{k}"][0] for k in range(2 * OPERAND)]
        behind = [cell for cell in _cells(module, "TRELLIS_FF") if cell["connections"]["DI"][0] in nets
                  and cell["parameters"]["CEMUX"] == "CE"]
        if behind:
            return behind, nets[0]
    raise AssertionError("no product has such registers")


def _invert_enables(module):
    for cell in _cells(module, "TRELLIS_FF"):
        if cell["parameters"]["CEMUX"] == "CE":
            cell["parameters"]["CEMUX"] = "INV"


def _begin_with_ones(module):
    for cell in _cells(module, "TRELLIS_FF"):
        cell["parameters"]["REGSET"] = "SET"


def _invert_clocks(module):
    for cell in _cells(module, "TRELLIS_FF"):
        cell["parameters"]["CLKMUX"] = "INV"


def _reset_words(module):
    memory, = _cells(module, "DP16KD")
    memory["connections"] |= {"RSTA": ["1"], "RSTB": ["1"]}


def _clock_words_otherwise(module):
    memory, = _cells(module, "DP16KD")
    memory["connections"] |= {"CLKA": ["1"], "CLKB": ["1"]}


def _register_a_product_twice(module):
    behind, net = _held(module)
    register, = (cell for cell in behind if cell["connections"]["DI"] == [net])
    module["cells"]["twin"] = {**register, "connections": {**register["connections"], "Q": [1 << 20]}}


def _enable_by_a_product(module):
    behind, net = _held(module)
    register, = (cell for cell in behind if cell["connections"]["DI"] == [net])
    # It is all that reads the product.
    module["cells"] = {name: cell for name, cell in module["cells"].items() if cell is register or cell not in behind}
    register["connections"] |= {"CE": [net], "DI": ["0"]}


def _always_enable_a_product(module):
    for cell in _held(module)[0]:
        cell["parameters"]["CEMUX"] = "1"


def _clear_a_pin(module):
    """Of an operand that is not negative it is none of a register."""
    for product in _cells(module, "MULT18X18D"):
        product["connections"]["A17"] = ["0"]


@pytest.mark.parametrize(("change", "operand", "product", "word"), [
    (_clear_a_pin, 2, 4, WIDTH),
    (_invert_enables, 1, 2, 0), (_begin_with_ones, 0, 0, 0), (_invert_clocks, 0, 0, 0), (_reset_words, 2, 4, 0),
    (_clock_words_otherwise, 2, 4, 0), (_register_a_product_twice, 2, 2, WIDTH), (_enable_by_a_product, 2, 2, WIDTH),
    # The operands of that product keep their enable.
    (_always_enable_a_product, 1, 4, WIDTH)])
def test_only_registers_that_may_not_move_stay(netlist, change, operand, product, word):
    module = copy.deepcopy(netlist)
    change(module)
    assert absorb(module) == {"operand": operand * OPERAND, "product": product * OPERAND, "block RAM": word}


@pytest.mark.parametrize("seed", range(3))
def test_the_netlist_does_the_same(netlist, seed):
    module = copy.deepcopy(netlist)
    absorb(module)
    assert list(_run(module, seed)) == list(_run(netlist, seed))


def test_a_register_of_another_enable_would_be_noticed(netlist):
    """What the comparison can see: an enable that is lost."""
    module = copy.deepcopy(netlist)
    absorb(module)
    for cell in module["cells"].values():
        if cell["type"] in ("MULT18X18D", "DP16KD"):
            cell["connections"] |= {pin: ["1"] for pin in ("CE0", "OCEA", "OCEB") if pin in cell["connections"]}
    assert list(_run(module, 1)) != list(_run(netlist, 1))


def _run(module, seed, cycles=200):
    """The outputs of each cycle, for random inputs; nothing is written, and words are a function of their address."""
    rng = random.Random(seed)
    cells = [cell for cell in module["cells"].values() if not cell["type"].startswith("$")]
    state = {}
    for _ in range(cycles):
        bits = {"0": 0, "1": 1, "x": 0}
        for name, port in module["ports"].items():
            if port["direction"] == "input":
                bits |= {bit: rng.randrange(2) if name not in ("write", "rst") else 0 for bit in port["bits"]}
        cycle = [_Cell(cell, bits, state.setdefault(id(cell), {})) for cell in cells]
        # Outputs of registers first, then what combines them.
        for cell in sorted(cycle, key=lambda cell: not cell.is_clocked):
            cell.drive()
        yield [bits[bit] for port in module["ports"].values() if port["direction"] == "output" for bit in port["bits"]]
        for update in [cell.clock() for cell in cycle]:
            update()


class _Cell:
    """A cell in a cycle; ``state`` is what its registers hold."""

    def __init__(self, cell, bits, state):
        self._pins, self._parameters, self._kind = cell["connections"], cell["parameters"], cell["type"]
        self._bits, self._state = bits, state
        self._in, self._out = (self._parameters.get(f"REG_{at}_CLK") == "CLK0" for at in ("INPUTA", "OUTPUT"))
        self.is_clocked = self._kind in ("TRELLIS_FF", "DP16KD") or self._out or self._in
        assert self._kind in ("TRELLIS_FF", "DP16KD", "MULT18X18D")

    def _get(self, pin):
        return self._bits[self._pins[pin][0]]

    def _set(self, pin, value):
        for bit in self._pins.get(pin, []):
            self._bits[bit] = value

    def _number(self, pin, count=18):
        value = sum(self._get(f"{pin}{k}") << k for k in range(count))
        return value - (value >> (count - 1) << count)

    def drive(self):
        if self._kind == "TRELLIS_FF":
            self._set("Q", self._state.get("q", 0))
        elif self._kind == "DP16KD":
            for port in "AB":
                word = self._state.get(f"{port} {self._parameters[f'REGMODE_{port}']}", 0)
                for k in range(18):
                    self._set(f"DO{port}{k}", word >> k & 1)
        else:
            product = self._state.get("p", 0) if self._out else self._product()
            for k in range(36):
                self._set(f"P{k}", product >> k & 1)

    def _product(self):
        return self._state.get("ab", 0) if self._in else self._number("A") * self._number("B")

    def clock(self):
        """What the edge does, to be done when all have seen the cycle."""
        new = {}
        if self._kind == "TRELLIS_FF":
            if self._parameters["CEMUX"].strip() == "1" or self._get("CE"):
                new["q"] = self._get("DI")
        elif self._kind == "DP16KD":
            for port in "AB":
                address = sum(self._get(f"AD{port}{k}") << k for k in range(14))
                new[f"{port} NOREG"] = random.Random(address).getrandbits(18)
                if self._get(f"OCE{port}"):
                    new[f"{port} OUTREG"] = self._state.get(f"{port} NOREG", 0)
        elif self.is_clocked and self._get("CE0"):
            new["p"] = self._product()
            if self._in:
                new["ab"] = self._number("A") * self._number("B")
        return lambda: self._state.update(new)
