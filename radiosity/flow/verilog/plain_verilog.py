"""Verilog 2005 from the SystemVerilog that `radiosity.flow.verilog.export.verilog_of` writes."""

import re
from collections import Counter
from dataclasses import dataclass
from itertools import groupby

__all__ = ["plain_verilog"]

_NAME = r"(?:\\\S+ |[A-Za-z_][\w$]*)"
_SLICE = re.compile(rf"({_NAME})(?:\[(\d+)(?::(\d+))?\])?|(\d+'[hdb][\da-fxz]+)")
_MODULE = re.compile(r"(?ms)^module .*?^endmodule\n")
_DECLARATION = re.compile(rf"(?m)^  (?:wire|reg|input|output) (?:signed )?(?:\[(\d+):0\] )?({_NAME})")
_BLOCK = re.compile(r"(?m)^  always_comb( begin)?\n((?:    .*\n)+)(?(1)  end\n)")
_COMMENT = re.compile(r"/\*.*?\*/;?|\(\*.*?\*\)")
_DIGITS = {"h": 4, "b": 1}
# Bits of a selector that are compared one by one.
_NARROW = 6


def plain_verilog(text: str) -> str:
    """The same modules with combinational logic that each dialect evaluates at time 0.

    An ``always @*`` waits for an event before it runs first, and SystemVerilog has none at time 0 where Verilog 2005
    has one. A continuous assignment waits for nothing: of each block there is one for every run of bits that it writes
    together. Its value is chosen by the conditions of the block, the last first.

    Raises
    ------
    RuntimeError
        A block has a form that Yosys does not write.
    """
    return _MODULE.sub(lambda module: _Module(module[0]).text(), text)


@dataclass(frozen=True)
class _Assignment:
    """Bits of signals, the lowest first, and those of the value that they get."""

    target: list
    value: list


@dataclass(frozen=True)
class _Choice:
    """Conditions, each with what is done under the first that holds; None holds always."""

    branches: list


@dataclass(frozen=True, eq=False)
class _Mux:
    """A value: ``chosen`` under a condition, ``otherwise`` without it."""

    condition: str
    chosen: "str | _Mux"
    otherwise: "str | _Mux"


class _Module:
    """A module whose combinational blocks become assignments."""

    def __init__(self, text):
        self._text, self._driven, self._wires = text, set(), 0
        self._widths = {name.strip(): int(last or 0) + 1 for last, name in _DECLARATION.findall(text)}

    def text(self) -> str:
        """The module with continuous assignments, which drive nets."""
        text = _BLOCK.sub(self._assigned, self._text)
        return re.sub(rf"(?m)^  reg ((?:signed )?(?:\[\d+:0\] )?)({_NAME});$", lambda line: (
            f"  wire {line[1]}{line[2]};" if line[2].strip() in self._driven else line[0]), text)

    def _assigned(self, block):
        """A block as assignments."""
        lines = [_COMMENT.sub("", line).strip() for line in block[2].splitlines()]
        try:
            statements = _Statements([*filter(None, lines), "end"], self._widths).sequence()
            runs = _runs(statements)
            values = self._values(statements, runs, {})
        except (KeyError, ValueError, IndexError) as error:
            raise RuntimeError(
                f"Yosys must write combinational blocks in the form that is known, not\n{block[0]}") from error
        self._driven |= {name for (name, _), *_ in runs}
        return "".join(self._assignment(run, values[run]) for run in runs)

    def _values(self, statements, runs, values):
        """What each run of bits has after statements, from what they had before."""
        bits = {}
        for one in statements:
            if isinstance(one, _Choice):
                self._choose(one, runs, values)
                bits = {}
                continue
            bits |= zip(one.target, one.value, strict=True)
            for run in runs:
                if not bits.keys().isdisjoint(one.target) and all(bit in bits for bit in run):
                    values[run] = self._spelled([bits[bit] for bit in run])
        return values

    def _choose(self, choice, runs, values):
        """Let the conditions of a choice decide about what its branches write."""
        written = {bit for target, _ in _targets([choice]) for bit in target}
        ends = [(condition, self._values(branch, runs, dict(values))) for condition, branch in choice.branches]
        for run in runs:
            if run[0] in written:
                value = values.get(run)
                for condition, after in reversed(ends):
                    value = after.get(run) if condition is None else _mux(condition, after.get(run), value)
                values[run] = value

    def _assignment(self, run, value):
        """An assignment, after wires of what it has more than once."""
        uses, lines, names = Counter(), [], {}
        _count(value, uses)
        for node in uses:
            if uses[node] > 1:
                self._wires += 1
                names[node] = f"\\$comb{self._wires} "
        width = f"[{len(run) - 1}:0] " if len(run) > 1 else ""
        for node, name in reversed(names.items()):
            lines += [f"  wire {width}{name};\n", f"  assign {name}= {_written(node, names)};\n"]
        return "".join([*lines, f"  assign {self._spelled(run)} = {_written(value, names)};\n"])

    def _spelled(self, bits):
        """A concatenation, of bits with the lowest first."""
        parts = []
        ordered = [(name, bit - number if name else 0, bit) for number, (name, bit) in enumerate(bits)]
        for (name, _), run in groupby(ordered, key=lambda one: one[:2]):
            values = [bit for *_, bit in run]
            if not name:
                parts.append(_number("".join(reversed(values))))
            elif len(values) == self._widths[name]:
                parts.append(_escaped(name))
            else:
                parts.append(f"{_escaped(name)}[{values[-1]}{f':{values[0]}' if len(values) > 1 else ''}]")
        return parts[0] if len(parts) == 1 else f"{{ {', '.join(reversed(parts))} }}"


class _Statements:
    """The statements of a block, line by line, up to an ``end`` that it does not begin."""

    def __init__(self, lines, widths):
        self._lines, self._widths, self._next = lines, widths, 0

    def sequence(self) -> list:
        """What stands before the next ``end`` or label."""
        found = []
        while not (line := self._lines[self._next]).startswith("end") and not line.endswith(":"):
            self._next += 1
            if line == "begin":
                found += self.sequence()
                self._next += 1
            elif line.startswith("if ("):
                found.append(_Choice(self._branches(line)))
            elif line.startswith("casez ("):
                found.append(_Choice(self._cases(line.removeprefix("casez (").removesuffix(")"))))
            else:
                target, value = line.removesuffix(";").split(" = ")
                found.append(_Assignment(self._bits(target), self._bits(value)))
                if len(found[-1].target) != len(found[-1].value):
                    raise ValueError(line)
        return found

    def _branches(self, line):
        branches = []
        while line != "end":
            condition = re.fullmatch(r"(?:end else )?if \((.*)\) begin|end else begin", line)
            branches.append((condition[1], self.sequence()))
            line = self._lines[self._next]
            self._next += 1
        return branches

    def _cases(self, selector):
        """One condition for each label; of a narrow selector one for each of its bits, which simulates faster."""
        cases, default = [], []
        while (line := self._lines[self._next]) != "endcase":
            self._next += 1
            branch = self.sequence()
            if line == "default:":
                default = branch
            else:
                cases += [(label, branch) for label in line.removesuffix(":").split(", ")]
        self._next += 1
        bits = self._bits(selector)
        if len(bits) > _NARROW:
            return [*((_equal(selector, label), branch) for label, branch in cases), (None, default)]
        digits = [("".join(reversed(_digits(label))), branch) for label, branch in cases]
        return self._tree([*reversed(bits)], digits, default)

    def _tree(self, bits, cases, default):
        """Choose the first case whose digits are those of the bits, the highest first."""
        if not cases:
            return [(None, default)]
        if not cases[0][0].strip("?"):
            return [(None, cases[0][1])]
        (name, bit), *rest = bits
        high, low = (self._tree(rest, [(digits[1:], branch) for digits, branch in cases if digits[0] in (value, "?")],
                                default) for value in "10")
        condition = f"{_escaped(name)}[{bit}]" if self._widths[name] > 1 else _escaped(name)
        return [(condition, [_Choice(high)]), (None, [_Choice(low)])]

    def _bits(self, text):
        """The bits of a concatenation of signals and constants, the lowest first; a constant has no name."""
        bits = []
        for name, high, low, constant in _SLICE.findall(text):
            if name:
                first = int(low or high or 0)
                last = int(high) if high else self._widths[name.strip()] - 1
                bits = [(name.strip(), bit) for bit in range(first, last + 1)] + bits
            else:
                bits = [("", bit) for bit in _digits(constant)] + bits
        if not bits or _SLICE.sub("", text).strip("{, }"):
            raise ValueError(text)
        return bits


def _digits(constant):
    """The binary digits of a constant, the lowest first."""
    width, base, digits = re.fullmatch(r"(\d+)'([hdb])([\da-fxz?]+)", constant).groups()
    if base == "d":
        digits, base = f"{int(digits):b}", "b"
    bits = "".join(digit * _DIGITS[base] if digit in "xz?" else f"{int(digit, 16):0{_DIGITS[base]}b}"
                   for digit in digits)
    return [*reversed(bits.zfill(int(width))[-int(width):])]


def _number(bits):
    """A constant."""
    known = not set(bits) & {"x", "z"}
    return f"{len(bits)}'h{int(bits, 2):0{-(-len(bits) // 4)}x}" if known else f"{len(bits)}'b{bits}"


def _equal(selector, label):
    """Whether a selector has the value of a label, of which a ``?`` is any digit."""
    if "?" not in label:
        return f"{selector} == {label}"
    digits = "".join(reversed(_digits(label)))
    cared = _number("".join("0" if digit == "?" else "1" for digit in digits))
    return f"({selector} & {cared}) == {_number(digits.replace('?', '0'))}"


def _targets(statements, path=()):
    """The targets of all assignments, each with its place: the branches around it and the choices before it."""
    before = 0
    for one in statements:
        if isinstance(one, _Choice):
            before += 1
            for number, (_, branch) in enumerate(one.branches):
                yield from _targets(branch, (*path, before, number))
        else:
            yield one.target, (*path, before)


def _runs(statements):
    """Successive bits of a signal that are written at the same places."""
    places = {}
    for target, place in _targets(statements):
        for bit in target:
            places.setdefault(bit, []).append(place)
    return [tuple(bit for _, bit in run) for _, run in groupby(
        enumerate(sorted(places)), key=lambda one: (one[1][0], one[1][1] - one[0], places[one[1]]))]


def _mux(condition, chosen, otherwise):
    """One of two values; None is a value that is never used."""
    if chosen is None or otherwise is None:
        return otherwise if chosen is None else chosen
    return otherwise if chosen == otherwise else _Mux(condition, chosen, otherwise)


def _count(value, uses):
    """Count the uses of each choice in a value, those outside before those inside."""
    while isinstance(value, _Mux):
        uses[value] += 1
        if uses[value] > 1:
            return
        _count(value.chosen, uses)
        value = value.otherwise


def _written(value, names):
    """A value in Verilog, with the wires of ``names`` where they are inside."""
    parts, top = [], value
    while isinstance(value, _Mux) and (value is top or value not in names):
        chosen = value.chosen
        inner = chosen if isinstance(chosen, str) else names.get(chosen) or f"({_written(chosen, names)})"
        parts.append(f"{value.condition} ? {inner} :")
        value = value.otherwise
    last = value if isinstance(value, str) else names[value]
    return f"{parts[0]} {last}" if len(parts) == 1 else "\n    ".join([*parts, last])


def _escaped(name):
    """A name as Verilog has it: an escaped one ends with a blank."""
    return f"{name} " if name.startswith("\\") else name
