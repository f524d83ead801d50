"""Direct-mapped and set-associative placement: the line of a record."""

from itertools import combinations

from amaranth.hdl import Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.generations import Generations
from hw.lib.update_memory import UpdateMemory
from hw.lib.validate import check_power_of_two

__all__ = ["SetPlacement"]


class SetPlacement(wiring.Component):
    """Direct-mapped or set-associative: line ``way sets + key mod sets``. A set replaces its least recently used way.

    A row of the memory is a set: the generation that wrote it, and for each way the rest of its key, whether it is
    full, and which other ways were used before it. In a new set the ways count as used in ascending order, so empty
    ways are filled first, and in that order.

    Parameters
    ----------
    lines, ways
        Powers of two; 1, 2 or 4 ways.
    key, tag
        Shapes of a key, and of a sideband value of a request.
    generation_bits
        See `Generations`.

    Members
    -------
    i_start : In, stream without payload
        Empties all lines. Only while no request is in flight.
    direct : In(1)
        Direct-mapped: line = key mod lines, whatever the ways. Stable until the next start.
    i : In, stream of ``tag``, ``key``
        Requests. Always ready, but only after the first start, and while no start is pending.
    o : Out, stream of ``tag``, ``line``, ``hit``
        Their lines. Always ready.

    Timing
    ------
    Latency: ``5`` cycles. One request per cycle, hit or miss; never stalls. A start takes ``1`` cycle, and ``lines /
    ways`` more every 2^``generation_bits`` - 1 starts.

    Raises
    ------
    TypeError
        The number of lines is no integer.
    ValueError
        A number is out of range.

    Golden counterpart: `golden.engine.memsys.bus.set_placement.SetPlacement`.
    """

    latency = 5

    def __init__(self, *, lines: int, ways: int, key, tag, generation_bits: int):
        if ways not in (1, 2, 4):
            raise ValueError(f"Ways must be 1, 2 or 4, not {ways!r}")
        check_power_of_two("Lines", lines, minimum=2 * ways)
        self._lines, self._ways, self._generation_bits = lines, ways, generation_bits
        super().__init__({
            "i_start": In(stream.Signature(0)), "direct": In(1),
            "i": In(stream.Signature(StructLayout({"tag": tag, "key": key}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "line": range(lines), "hit": 1}), always_ready=True))})
        self._tag = tag

    def elaborate(self, platform):
        m = Module()
        ways, sets = self._ways, self._lines // self._ways
        set_bits, way_bits = sets.bit_length() - 1, ways.bit_length() - 1
        key = Value.cast(self.i.payload.key)
        number, forced, rest = key[:set_bits], key[set_bits:set_bits + way_bits], key[set_bits:]
        pairs = list(combinations(range(ways), 2))
        # ``hit`` and ``way`` are never read from the memory: they are the result of the access that writes the row.
        row = StructLayout({"generation": self._generation_bits, "rest": ArrayLayout(len(rest), ways), "full": ways,
                            "before": len(pairs), "hit": 1, "way": way_bits})
        operand = StructLayout({"generation": self._generation_bits, "clear": 1, "rest": len(rest), "direct": 1,
                                "forced": ways})

        def change(m, old, operand):
            """The set after an access."""
            fresh = old.generation == operand.generation
            before = Mux(fresh, old.before, ~Const(0, len(pairs)))
            # Signals, as all of the row depends on them: an expression is built anew wherever it is used.
            found, takes = Signal(ways, name="found"), Signal(ways, name="takes")
            m.d.comb += found.eq(Cat(fresh & old.full[way] & (old.rest[way] == operand.rest)
                                     & (operand.forced[way] | ~operand.direct) for way in range(ways)))
            oldest = Cat(Cat(before[k] if way == a else ~before[k] for k, (a, b) in enumerate(pairs)
                             if way in (a, b)).all() for way in range(ways))
            hit = found.any()
            m.d.comb += takes.eq(Mux(hit, found, Mux(operand.direct, operand.forced, oldest)))
            # In the order of the row's fields.
            return Cat(
                operand.generation,
                *(Mux(takes[way], operand.rest, old.rest[way]) for way in range(ways)),
                *(~operand.clear & (takes[way] | (fresh & old.full[way])) for way in range(ways)),
                *(~takes[a] & (takes[b] | before[k]) for k, (a, b) in enumerate(pairs)),
                hit, *(Cat(takes[way] for way in range(ways) if way >> bit & 1).any() for bit in range(way_bits))
            ), Const(1)

        m.submodules.generations = generations = Generations(bits=self._generation_bits, depth=sets)
        wiring.connect(m, wiring.flipped(self.i_start), generations.i_start)
        tag = StructLayout({"tag": self._tag, "is_request": 1})
        m.submodules.sets = memory = UpdateMemory(row, depth=sets, operand=operand, tag=tag, change=change)
        # Registered: a block RAM has no slack for a multiplexer at its address.
        given, accesses = Signal.like(memory.i.payload, reset_less=True), Signal()
        done = memory.o.payload
        m.d.sync += [
            accesses.eq(self.i.valid | generations.sweeps),
            given.address.eq(Mux(generations.sweeps, generations.row, number)),
            given.tag.tag.eq(self.i.payload.tag), given.tag.is_request.eq(self.i.valid),
            given.operand.generation.eq(Mux(generations.sweeps, 0, generations.generation)),
            given.operand.clear.eq(generations.sweeps), given.operand.rest.eq(rest),
            given.operand.direct.eq(self.direct), given.operand.forced.eq(1 << forced)]
        m.d.comb += [
            memory.i.valid.eq(accesses), memory.i.payload.eq(given),
            self.o.valid.eq(memory.o.valid & done.tag.is_request), self.o.payload.tag.eq(done.tag.tag),
            self.o.payload.line.eq(Cat(done.address, done.new.way)), self.o.payload.hit.eq(done.new.hit)]
        return m
