"""Pipelines whose delays are computed: values carry their age, and operands are aligned to the same age."""

from collections.abc import Callable
from functools import reduce
from itertools import pairwise
from operator import or_

from amaranth.hdl import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib.data import View
from amaranth.lib.memory import Memory

from hw.lib.validate import check_integer

__all__ = ["OPERAND", "Pipeline", "Staged"]

# A memory with a counter takes less area than this many registers in a row; and the depth of one memory of LUTs, the
# most cycles for which it can hold a value.
LONG = 6
DEEPEST = 16
# Bits of an operand of a DSP block.
OPERAND = 18


class Staged:
    """A value of the item that entered a pipeline ``age`` cycles ago. Made by `Pipeline` only.

    Members
    -------
    value
        Amaranth value (or view) that holds it.
    age
        Registers between the pipeline's input and the value.
    """

    def __init__(self, value, age: int):
        self.value, self.age = value, age
        self._older = None
        self._is_first, self._is_used = True, False
        # Cycles for which a register has held it.
        self._held = 0

    def __repr__(self) -> str:
        return f"<value of age {self.age}>"


class Pipeline:
    """A chain of registers from a stream to a stream; one item per cycle, items never overtake.

    Operators are functions that take the pipeline and `Staged` values and give `Staged` values; each says by the age of
    its result how many registers it takes. Wherever values of different age meet, `Pipeline` inserts the registers
    that the younger ones lack, shared between all their users. So latency is a result: it is known when the last output
    has been named, before elaboration. Where a value only waits for long, a small memory takes the registers' place.

    The datapath is described in a component's constructor and becomes registers with `add_to`::

        pipeline = Pipeline(self.i, self.o)
        x, y = (pipeline.input(self.i.payload[name]) for name in "xy")
        total = pipeline.register(lambda x, y: x + y, x, y)
        pipeline.output(self.o.payload, total)
        self.latency = pipeline.latency

    Parameters
    ----------
    i, o
        Streams as the component sees them. If ``o`` is always ready nothing stalls, and ``i`` may be always ready too.
        Otherwise the whole chain stalls while an item at its end waits for ``o``.
    interval
        Cycles from an item to the next one, at least. Where they are several a register holds its value for all of
        them, and products share multipliers: one that is busy puts a product off, and with it what follows.
    ready_next
        Value: whether ``o`` is ready in the next cycle. With it the enable of all registers comes from a register, not
        from ``o`` through logic.

    Members
    -------
    latency
        Cycles from an item's transfer at ``i`` to the first cycle in which ``o`` shows it.

    Timing
    ------
    Latency: what the operators add up to. One item per ``interval`` cycles; stalls only with ``o``.

    Raises
    ------
    TypeError
        ``interval`` is no integer.
    ValueError
        ``i`` is always ready but ``o`` is not; ``interval`` is out of range, or more than 1 where ``o`` can wait;
        there is a ``ready_next`` and ``o`` is always ready.
    """

    def __init__(self, i, o, *, interval: int = 1, ready_next=None):
        check_integer("Interval", interval, minimum=1)
        self._i, self._o, self._interval = i, o, interval
        self._stalls = not o.signature.always_ready
        if self._stalls and i.signature.always_ready:
            raise ValueError("Input must be a stream that can wait where the output can, not one that is always ready")
        if self._stalls and interval > 1:
            raise ValueError(f"Interval must be 1 where the output can wait, not {interval!r}")
        if ready_next is not None and not self._stalls:
            raise ValueError("Next cycle's ready is of an output that can wait, not of one that is always ready")
        self._ready_next = ready_next
        self._advance = Signal(name="advance", init=ready_next is not None) if self._stalls else None
        self._delayed, self._ports, self._outputs = [], [], []
        self._held, self._multipliers, self._rounds = [], [], []
        self._kept = None
        self._valid = [Staged(i.valid, 0)]

    def input(self, value) -> Staged:
        """A value of the item that enters; any value that is given together with it."""
        return Staged(value, 0)

    def constant(self, value) -> Staged:
        """A value that does not change while items are in the pipeline: of any age, so it is never delayed."""
        return Staged(value, None)

    def combine(self, function: Callable, *operands: Staged) -> Staged:
        """``function`` of equally old values, without a register."""
        age = self._age(operands)
        result = function(*(self._at(operand, age).value for operand in operands))
        return Staged(result if isinstance(result, View) else Value.cast(result), age)

    def register(self, function: Callable, *operands: Staged, registers: int = 1) -> Staged:
        """``function`` of equally old values, with registers behind it; of a tuple of results a tuple."""
        age = self._age(operands)
        age = 0 if age is None else age
        result = function(*(self._at(operand, age).value for operand in operands))
        if isinstance(result, tuple):
            return tuple(self.delay(Staged(value, age), registers) for value in result)
        return self.delay(Staged(result, age), registers)

    def delay(self, operand: Staged, cycles: int) -> Staged:
        """The same value ``cycles`` older."""
        if operand.age is None:
            return operand
        return self._at(operand, operand.age + cycles)

    def before(self, operand: Staged, items: int) -> Staged:
        """The value that the item ``items`` intervals ahead had: that of the one before, if they come without a gap.

        Raises
        ------
        ValueError
            The pipeline can stall.
        """
        if self._stalls:
            raise ValueError("Output must be always ready for items to follow each other without a gap")
        return Staged(self._at(operand, operand.age + items * self._interval).value, operand.age)

    def align(self, *operands: Staged) -> tuple[Staged, ...]:
        """The same values, equally old."""
        age = self._age(operands)
        return tuple(self._at(operand, age) for operand in operands)

    def product(self, a: Staged, b: Staged, *, registers: int) -> Staged:
        """``a b`` in one DSP block: one register behind it, of more the second in front of it, the others behind.

        The registers in front have no other sinks, so that they can be placed inside the DSP block.
        """
        if self._interval > 1:
            return self._shared_product(a, b, max(1, registers))
        if registers >= 2:
            a, b = self.align(a, b)
            a, b = (Staged(operand.value, operand.age) for operand in (a, b))
            a, b = self.delay(a, 1), self.delay(b, 1)
        return self.register(lambda a, b: a * b, a, b, registers=max(1, registers - 1))

    def rounds(self, function: Callable, count: int, *operands: Staged) -> tuple[Staged, ...]:
        """``operands`` in registers, and ``count`` times what ``function`` of the round's number and of their values
        makes of them: ``count + 1`` cycles.

        The number is an int with registers for each round; where items are several cycles apart it is a value, and as
        many rounds as there are cycles have one set of registers. Values keep their widths.
        """
        age = self._age(operands)
        operands = [self._at(operand, age) for operand in operands]
        if self._interval == 1:
            values = self.register(lambda *values: values, *operands)
            for number in range(count):
                values = self.register(lambda *values, number=number: function(number, *values), *values)
            return values
        values = [operand.value for operand in operands]
        done = 0
        while True:
            # A set passes its last round on to the next set while it accepts the next item; the last set keeps it.
            here = min(self._interval, count - done)
            registers = [Signal(Value.cast(value).shape(), reset_less=True) for value in values]
            number = Signal(range(done, done + here), init=done) if here > 1 else done
            following = function(number, *registers) if here else registers
            self._rounds.append((age, registers, values, following, number, done))
            if here < self._interval:
                break
            done, age, values = done + here, age + here, following
        return tuple(Staged(register, age + here + 1) for register in registers)

    def read(self, port, address: Staged) -> Staged:
        """What a memory's read port (domain ``sync``) gives for an address: one cycle older."""
        self._ports.append((port, address))
        return Staged(port.data, address.age + 1)

    def valid(self, age: int) -> Value:
        """Whether there is an item of this age."""
        while len(self._valid) <= age:
            self._valid.append(Staged(Signal(name=f"valid_{len(self._valid)}"), len(self._valid)))
        return self._valid[age].value

    def moves(self, age: int) -> Value:
        """Whether an item of this age advances in this cycle: for what must happen once per item."""
        return self.valid(age) & self._advance if self._stalls else self.valid(age)

    def output(self, target, operand: Staged) -> None:
        """Drive a part of ``o``'s payload. All parts are delayed to the age of the oldest."""
        self._outputs.append((target, operand))

    def keep(self, condition: Staged) -> None:
        """Only items of which ``condition`` is 1 come out."""
        self._kept = condition

    @property
    def latency(self) -> int:
        """See above."""
        return max([1, *(operand.age for _, operand in self._outputs if operand.age is not None)])

    def add_to(self, m) -> None:
        """Put the registers into the module of the component."""
        latency = self.latency
        for target, operand in self._outputs:
            m.d.comb += target.eq(self._at(operand, latency).value)
        valid = self.valid(latency)
        if self._kept is not None:
            valid = valid & self._at(self._kept, latency).value
        for multiplier in self._multipliers:
            multiplier.add_to(m, self.valid)
        for age, registers, values, following, number, first in self._rounds:
            with m.If(self.valid(age)):
                m.d.sync += [register.eq(value) for register, value in zip(registers, values, strict=True)]
            with m.Else():
                m.d.sync += [register.eq(value) for register, value in zip(registers, following, strict=True)]
            if isinstance(number, Signal):
                m.d.sync += number.eq(Mux(self.valid(age), first, number + 1))
        for register, source, age in self._held:
            with m.If(self.valid(age)):
                m.d.sync += register.eq(source)
        m.d.comb += self._o.valid.eq(valid)
        if self._ready_next is not None:
            m.d.sync += self._advance.eq(
                self._ready_next | ~Mux(self._advance, self.valid(latency - 1), self.valid(latency)))
        elif self._stalls:
            m.d.comb += self._advance.eq(self._o.ready | ~self._o.valid)
        if not self._i.signature.always_ready:
            m.d.comb += self._i.ready.eq(self._advance if self._stalls else 1)
        for port, address in self._ports:
            m.d.comb += [port.addr.eq(address.value), port.en.eq(self._advance if self._stalls else 1)]
        valid = [stage.value for stage in self._valid]
        registers = [*self._delays(m), *zip(valid[1:], valid[:-1], strict=True)]
        with m.If(self._advance if self._stalls else 1):
            m.d.sync += [target.eq(source) for target, source in registers]

    def module(self) -> Module:
        """The module of a component that has nothing else."""
        m = Module()
        self.add_to(m)
        return m

    def _shared_product(self, a, b, registers):
        """As soon as a multiplier is free at an age; items never meet at one whose ages are within an interval."""
        first = self._age((a, b)) or 0
        width = max(OPERAND, *(len(value) + (not value.shape().signed) for value in (Value.cast(a.value),
                                                                                     Value.cast(b.value))))
        alike = [one for one in self._multipliers if (one.width, one.registers) == (width, registers)]
        age, multiplier = min(((age, one) for one in alike for age in [one.free(first, self._interval)]
                               if age is not None), key=lambda found: found[0], default=(first, None))
        if multiplier is None:
            multiplier = _Multiplier(width, registers)
            self._multipliers.append(multiplier)
        return Staged(multiplier.product(age, self._at(a, age).value, self._at(b, age).value), age + registers)

    def _delays(self, m):
        """Registers, as pairs of target and source, that delay values to the ages at which they are used."""
        registers = []
        for stage in self._delayed:
            waits = []
            while stage._older is not None:
                waits.append(stage.value)
                stage = stage._older
                if stage._is_used:
                    registers += self._wait(m, [*waits, stage.value])
                    waits = []
        return registers

    def _wait(self, m, values):
        """From the first of ``values`` through a register each to the last; those between are used nowhere else."""
        registers = []
        while len(values) > LONG:
            first, depth = values[1], min(DEEPEST, len(values) - 3)
            last = values[depth + 2]
            registers += [(first, values[0]), (last, self._memory(m, first, depth))]
            values = values[depth + 2:]
        return registers + list(zip(values[1:], values[:-1], strict=True))

    def _memory(self, m, value, depth):
        """``value`` as it was ``depth`` items before."""
        value = Value.cast(value)
        memory = Memory(shape=len(value), depth=depth, init=[], attrs={"ram_style": "distributed"})
        write, read = memory.write_port(), memory.read_port(domain="comb")
        # Where it begins does not matter. A reset, which few registers of a counter can share, would be logic.
        index = Signal(range(depth), reset_less=True)
        m.submodules += memory
        m.d.comb += [write.addr.eq(index), write.data.eq(value), read.addr.eq(index),
                     write.en.eq(self._advance if self._stalls else 1)]
        with m.If(write.en):
            m.d.sync += index.eq(Mux(index == depth - 1, 0, index + 1))
        return read.data

    def _age(self, operands):
        return max((operand.age for operand in operands if operand.age is not None), default=None)

    def _at(self, operand, age):
        """``operand``, delayed to ``age``."""
        if operand.age is None or age is None:
            return operand
        if operand.age > age:
            raise AssertionError(f"a value of age {operand.age} is needed at age {age}")
        while operand.age < age:
            if operand._older is None:
                value = operand.value
                shape = value.shape() if isinstance(value, View) else Value.cast(value).shape()
                operand._older = older = Staged(operand.value, operand.age + 1)
                older._is_first = False
                if self._interval > 1 and 0 < operand._held < self._interval:
                    older._held = operand._held + 1
                else:
                    older.value = Signal(shape, reset_less=True, name=f"age_{older.age}")
                    older._held = 1
                    if self._interval > 1:
                        self._held.append((older.value, operand.value, operand.age))
                    elif operand._is_first:
                        self._delayed.append(operand)
            operand = operand._older
        operand._is_used = True
        return operand


class _Multiplier:
    """A multiplier for the products of several ages."""

    def __init__(self, width, registers):
        self.width, self.registers = width, registers
        self._operands, self._result = {}, Signal(signed(2 * width), reset_less=True)

    def free(self, first, interval):
        """The earliest age from ``first`` on at which it is free, or None."""
        return next((age for age in range(first, min(self._operands) + interval)
                     if age not in self._operands and max(self._operands) - age < interval), None)

    def product(self, age, a, b):
        """Of two values of an age, ``registers`` later."""
        self._operands[age] = a, b = Value.cast(a), Value.cast(b)
        result = self._result[:len(a) + len(b)]
        return result.as_signed() if a.shape().signed or b.shape().signed else result

    def _extended(self, value):
        return Cat(value, (value[-1] if value.shape().signed else Const(0, 1)).replicate(self.width - len(value)))

    def add_to(self, m, valid):
        """``valid``: whether there is an item of an age."""
        operands = [Signal(signed(self.width)) for _ in range(2)]
        for operand, values in zip(operands, zip(*self._operands.values(), strict=True), strict=True):
            # There is an item of one of the ages at most.
            m.d.comb += operand.eq(reduce(or_, (Mux(valid(age), self._extended(value), 0)
                                                for age, value in zip(self._operands, values, strict=True))))
        if self.registers > 1:
            front = [Signal(signed(self.width), reset_less=True) for _ in range(2)]
            m.d.sync += [register.eq(operand) for register, operand in zip(front, operands, strict=True)]
            operands = front
        behind = [Signal(signed(2 * self.width), reset_less=True) for _ in range(max(0, self.registers - 2))]
        for target, source in pairwise([self._result, *behind, operands[0] * operands[1]]):
            m.d.sync += target.eq(source)
