"""Bugs by rule, and conditions under which alone they show."""

import ast
import random

import pytest
from amaranth.hdl import Fragment
from amaranth.sim import Simulator

from tb.bugs.guards import guarded, guards
from tb.bugs.rules import changes
from tb.bugs.source import Source

PATH = "hw/icu/unit.py"


def texts(body, rule, path=PATH):
    """The file of each bug of a rule."""
    source = Source(path, body)
    return {(source.data[:one.begin] + one.new.encode() + source.data[one.end:]).decode()
            for one in changes(source) if one.rule == rule}


@pytest.mark.parametrize(("rule", "text", "expected"), [
    ("operators", "a = b + c", {"a = b - c"}), ("operators", "a = b * c - d", {"a = b * c + d", "a = (b + c) - d"}),
    ("operators", "a = b < c == d", {"a = b <= c == d", "a = b < c != d"}),
    ("operators", "a = b and (c or d)", {"a = b or (c or d)", "a = b and ((c and d))"}),
    ("operators", "a = b // 2", {"a = (-(-(b) // (2)))"}), ("operators", "a += 1", {"a -= 1"}),
    ("operators", "a = np.floor(b) << 1", {"a = np.ceil(b) << 1", "a = np.floor(b) >> 1"}),
    ("operators", "a = find(b, side='left')", {"a = find(b, side='right')"}), ("operators", "a = 'b' + c", set()),
    ("constants", "a = b[0x10:-1]", {"a = b[0x11:-1]", "a = b[0xf:-1]", "a = b[0x10:-2]"}),
    ("constants", "a = True", {"a = False"}), ("constants", "a: f[3] = b", set()), ("constants", "raise E(3)", set()),
    ("widths", "a = Signal(n)", {"a = Signal(n - 1)"}), ("widths", "a = Signal(range(n + 1))", {
        "a = Signal(range((n + 1) - 1))"}), ("widths", "a = n.bit_length()", {"a = (n.bit_length() - 1)"}),
    ("widths", "a = b[c:d]", {"a = b[c + 1:d]", "a = b[c:d - 1]"}),
    ("conditions", "a = b and c and d", {"a = (c and d)", "a = (b and d)", "a = (b and c)"}),
    ("conditions", "with m.If(~a & b):\n    pass", {
        "with m.If((a) & b):\n    pass", "with m.If((~a)):\n    pass", "with m.If((b)):\n    pass"}),
    ("conditions", "with m.If(a):\n    pass", {"with m.If(1):\n    pass"}),
    ("conditions", "if a:\n    raise b", {"if False:\n    raise b"}),
    ("conditions", "a = [b for b in c if b]", {"a = [b for b in c if True]"}),
    ("swaps", "f(a, b.c, 1)", {"f(b.c, a, 1)"}), ("swaps", "f(a=b, c=d)", {"f(a=d, c=b)"}),
    ("swaps", "a, b = c", {"b, a = c"}), ("swaps", "x = a if b else c", {"x = c if b else a"}),
    ("swaps", "x = Mux(a, b + 1, c)", {"x = Mux(a, c, b + 1)"}),
    ("swaps", "def f(a):\n    return a.b + a.c", {
        "def f(a):\n    return a.c + a.c", "def f(a):\n    return a.b + a.b"}),
    ("order", "def f(a):\n    c = g(a)\n    b = c\n    return b", set()),
    ("order", "def f(a, b):\n    a = g(a)\n    b += a\n    return b", {
        "def f(a, b):\n    b += a\n    a = g(a)\n    return b"}),
    ("state", "a = Signal(3, init=2)", {"a = Signal(3, init=0)"}),
    ("state", "def f(m):\n    a, b = Signal(), 1\n    m.d.sync += a.eq(b)", {
        "def f(m):\n    a, b = Signal(init=1), 1\n    m.d.sync += a.eq(b)",
        "def f(m):\n    a, b = Signal(reset_less=True), 1\n    m.d.sync += a.eq(b)"}),
    ("dropped", "m.d.sync += [a.eq(b), c.eq(d)]", {"m.d.sync += [c.eq(d)]", "m.d.sync += [a.eq(b)]"}),
    ("dropped", "m.d.comb += a.eq(b)", {"pass"}), ("dropped", "def f(a):\n    b = 1\n    b = 2", {
        "def f(a):\n    b = 1\n    pass"}), ("dropped", "wiring.connect(m, a, b)", {"pass"})])
def test_rules(rule, text, expected):
    assert texts(text, rule) == expected


@pytest.mark.parametrize("text", ['"""A page of 3."""', "import a.b", "__all__ = ['a']", "@f(3)\nclass A:\n    pass",
                                  "def f(a: b[3]) -> c[4]:\n    pass", "a = [1, 2, 3, 4, 5, 6, 7, 8, 9]"])
def test_what_does_nothing_stays(text):
    assert changes(Source(PATH, text)) == []


PYTHON = '''
def f(values, count: int, scale=1, *, whole=False):
    """Sums."""
    total = 0
    if count == 3:
        total = 100
    for value in values:
        total += value * scale
    return [one + total for one in values]
'''
CASES = [([1, 2, 3, 4, 5], 2, {}), ([], 2, {}), ([5, 6], 3, {}), ([7], 9, {}), ([1, 2], 1, {"scale": 3}),
         ([1, 2], 1, {"whole": True})]


def results(text):
    """What each of the cases gives, in one process; errors too."""
    names = {}
    exec(text, names)
    found = []
    for values, count, given in CASES:
        try:
            found.append(names["f"](values, count, **given))
        except (NameError, TypeError, IndexError) as error:
            found.append(type(error))
    return found


def edited(source, change, guard):
    """The file of a bug with a condition."""
    edits = [guarded(source, change, guard), *([guard.loop] if guard.loop else [])]
    data = source.data
    for begin, end, new in sorted(edits, reverse=True):
        data = data[:begin] + new.encode() + data[end:]
    return data.decode() + guard.helper


def test_in_combination_some_cases_are_right():
    """Every condition lets the old text run in some cases, and some do not: the bug is hidden, not absent."""
    source, kinds = Source("golden/a.py", PYTHON), set()
    right = results(PYTHON)
    for change in changes(source):
        alone = results((source.data[:change.begin] + change.new.encode() + source.data[change.end:]).decode())
        for guard in guards(source, change):
            combined = results(edited(source, change, guard))
            assert all(one in (good, bad) or guard.kind in ("iteration", "call")
                       for one, good, bad in zip(combined, right, alone, strict=True))
            kinds |= {guard.kind} if right != combined != alone else set()
    assert kinds == {"size", "option", "feature", "iteration", "call"}


HARDWARE = '''
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class Unit(wiring.Component):
    def __init__(self, *, config):
        self._config = config
        super().__init__({"i": In(4), "go": In(1), "o": Out(6)})

    def elaborate(self, platform):
        m = Module()
        count, kept = Signal(self._config.noc.nodes.bit_length()), Signal(4)
        with m.If(self.go):
            m.d.sync += [count.eq(count + 1), kept.eq(self.i)]
        with m.Else():
            m.d.sync += kept.eq(0)
        m.d.comb += self.o.eq(kept - self.i)
        return m
'''


def outputs(text):
    """Outputs of twenty cycles of drawn inputs."""
    from golden.engine.config import PRESETS
    names = {}
    exec(text, names)
    unit, found, draw = names["Unit"](config=PRESETS["small"]), [], random.Random(1)

    async def bench(ctx):
        for _ in range(20):
            ctx.set(unit.i, draw.randrange(16))
            ctx.set(unit.go, draw.randrange(2))
            found.append(ctx.get(unit.o))
            await ctx.tick()

    simulator = Simulator(Fragment.get(unit, None))
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    return found


def test_in_combination_hardware_is_right_at_first():
    """A register or earlier cycles decide in a component; a large configuration changes nothing in a small one."""
    source, kinds = Source(PATH, HARDWARE), set()
    right, draw = outputs(HARDWARE), random.Random(2)
    made = [(change, guard) for change in changes(source) for guard in guards(source, change)]
    assert {guard.kind for _, guard in made} == {"configuration", "register", "cycle"}
    for change, guard in draw.sample(made, 40):
        if (edit := guarded(source, change, guard)) is None:
            continue
        assert ast.parse(edited(source, change, guard)), edit
        try:
            found = outputs(edited(source, change, guard))
        except (TypeError, AttributeError, SyntaxError):  # does not count
            continue
        assert found[0] == right[0] or "== 0" in guard.condition
        if guard.kind == "configuration":
            assert found == right
        elif found != right:
            kinds.add(guard.kind)
    assert kinds == {"register", "cycle"}
