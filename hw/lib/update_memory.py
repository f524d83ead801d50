"""Update memory: a block RAM in which each item reads, changes and writes one row, one item per cycle."""

from collections.abc import Callable
from itertools import pairwise

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

__all__ = ["UpdateMemory"]


class UpdateMemory(wiring.Component):
    """``row, write = change(old, operand)``, as if each item were finished before the next one begins.

    An item that comes while up to four others are under way may need what they write: the three that are decided
    already are looked at when the old row arrives, the one just in front when the change is made.

    Parameters
    ----------
    shape, depth
        Of the rows.
    operand, tag
        Shapes of what an item changes its row by, and of what goes along.
    change
        From the old row and the operand to the new row and whether it is written.

    Members
    -------
    i
        ``tag``, ``address``, ``operand``. Always ready.
    o
        ``tag``, ``address``, ``old``, ``new``, ``written``. Always ready.

    Timing
    ------
    Latency: ``4`` cycles. One item per cycle; nothing stalls.
    """

    def __init__(self, shape, *, depth: int, operand, tag, change: Callable):
        self._shape, self._depth, self._change = shape, depth, change
        address = range(depth)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "address": address, "operand": operand}),
                                     always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "address": address, "old": shape, "new": shape,
                                                    "written": 1}), always_ready=True))})
        self.latency = 4

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._shape, depth=self._depth, init=[])
        read, write = memory.read_port(), memory.write_port()
        m.d.comb += [read.addr.eq(self.i.payload.address), read.en.eq(1)]

        # Items of age 1 to 3: what they are, and what row they have read.
        items, valid = [self.i.payload], [self.i.valid]
        for age in range(1, 4):
            item = Signal(self.i.payload.shape(), reset_less=True, name=f"item_{age}")
            there = Signal(name=f"valid_{age}")
            m.d.sync += [item.eq(items[-1]), there.eq(valid[-1])]
            items.append(item)
            valid.append(there)
        read_2, old_3 = (Signal(self._shape, reset_less=True) for _ in range(2))

        # Items of age 4 to 6 have written or not.
        done = []
        for age in range(4, 7):
            done.append({"written": Signal(name=f"written_{age}"),
                         "address": Signal(range(self._depth), reset_less=True, name=f"address_{age}"),
                         "row": Signal(self._shape, reset_less=True, name=f"row_{age}")})
        for earlier, later in pairwise(done):
            m.d.sync += [later[name].eq(earlier[name]) for name in earlier]

        def same(ahead):
            """Whether an item of age 2 is at the place of the one ``ahead`` of it; found when it was of age 1."""
            flag = Signal(name=f"same_as_{ahead}_ahead")
            place = (items[1 + ahead].address if 1 + ahead < 4 else done[1 + ahead - 4]["address"])
            m.d.sync += flag.eq(place == items[1].address)
            return flag

        m.d.sync += read_2.eq(read.data)
        merged = read_2
        for ahead in (4, 3, 2):
            of = done[2 + ahead - 4]
            merged = Mux(same(ahead) & of["written"], of["row"], merged)
        same_as_next = Signal()
        m.d.sync += [old_3.eq(merged), same_as_next.eq(items[3].address == items[2].address)]

        old = Signal(self._shape)
        m.d.comb += old.eq(Mux(same_as_next & done[0]["written"], done[0]["row"], old_3))
        row, written = self._change(old, items[3].operand)
        m.d.sync += [done[0]["written"].eq(written & valid[3]), done[0]["address"].eq(items[3].address),
                     done[0]["row"].eq(row)]
        out = self.o.payload
        m.d.sync += [self.o.valid.eq(valid[3]), out.tag.eq(items[3].tag), out.old.eq(old)]
        m.d.comb += [out.address.eq(done[0]["address"]), out.new.eq(done[0]["row"]),
                     out.written.eq(done[0]["written"]),
                     write.addr.eq(done[0]["address"]), write.data.eq(done[0]["row"]),
                     write.en.eq(done[0]["written"])]
        return m
