"""Update memory: a block RAM in which each item reads, changes and writes one row, one item per cycle."""

from collections.abc import Callable
from itertools import pairwise

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

__all__ = ["UpdateMemory"]

# Bits of a block RAM whose words are of 1, 2 or 4 bits; the most words of one that has more.
BLOCK, WIDE = 1 << 14, 1 << 11


class UpdateMemory(wiring.Component):
    """``row, write = change(m, old, operand)``, as if each item were finished before the next one begins.

    An item that arrives while up to five others are in flight may need their results. The results of the first four are
    forwarded when the old row arrives, that of the item directly ahead when the change is made. The new row has a
    cycle for the routing delay to the block RAMs.

    Parameters
    ----------
    shape, depth
        Of the rows.
    operand, tag
        Shapes of the operand of a change, and of the sideband data.
    change
        From the old row and the operand to the new row and whether it is written. It may add signals to the module
        ``m``; it is called twice.

    Members
    -------
    i : In, stream of ``tag``, ``address``, ``operand``, always ready
        Changes of rows.
    o : Out, stream of ``tag``, ``address``, ``old``, ``new``, ``written``, always ready
        The row before and after the change, and whether it was written.

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
        # Items of age 1 to 3: what they are, and what row they have read.
        items, valid = [self.i.payload], [self.i.valid]
        for age in range(1, 4):
            item = Signal(self.i.payload.shape(), reset_less=True, name=f"item_{age}")
            there = Signal(name=f"valid_{age}")
            m.d.sync += [item.eq(items[-1]), there.eq(valid[-1])]
            items.append(item)
            valid.append(there)
        read_1, read_2, old_3 = (Signal(self._shape, reset_less=True, name=name)
                                 for name in ("read_1", "read_2", "old_3"))

        # Items of age 4 to 6 are decided; they write at age 5.
        done = []
        for age in range(4, 7):
            done.append({"written": Signal(name=f"written_{age}"),
                         "address": Signal(range(self._depth), reset_less=True, name=f"address_{age}"),
                         "row": Signal(self._shape, reset_less=True, name=f"row_{age}")})
        for earlier, later in pairwise(done):
            m.d.sync += [later[name].eq(earlier[name]) for name in earlier]

        addresses = [item.address for item in items] + [item["address"] for item in done]
        m.d.sync += read_2.eq(read_1)
        # The last result that is known while the old row is still in the block RAM: a multiplexer less behind the block
        # RAM, which has a long routing delay.
        is_kept, kept = Signal(), Signal(self._shape, reset_less=True)
        m.d.sync += is_kept.eq(0)
        for ahead in (5, 4, 3):
            of = done[1 + ahead - 4]
            with m.If(self._same_as(m, addresses, ahead, age=1) & of["written"]):
                m.d.sync += [is_kept.eq(1), kept.eq(of["row"])]
        follows = self._same_as(m, addresses, 2, age=2) & done[0]["written"]
        m.d.sync += old_3.eq(Mux(follows, done[0]["row"], Mux(is_kept, kept, read_2)))

        # Which of the two is the old row is known late: the change is made to both.
        old, repeats = Signal(self._shape), Signal()
        m.d.comb += [repeats.eq(self._same_as(m, addresses, 1, age=3) & done[0]["written"]),
                     old.eq(Mux(repeats, done[0]["row"], old_3))]
        (row_again, again), (row, written) = (self._change(m, was, items[3].operand) for was in (done[0]["row"], old_3))
        m.d.sync += [done[0]["written"].eq(Mux(repeats, again, written) & valid[3]),
                     done[0]["address"].eq(items[3].address), done[0]["row"].eq(Mux(repeats, row_again, row))]
        out = self.o.payload
        m.d.sync += [self.o.valid.eq(valid[3]), out.tag.eq(items[3].tag), out.old.eq(old)]
        m.d.comb += [out.address.eq(done[0]["address"]), out.new.eq(done[0]["row"]),
                     out.written.eq(done[0]["written"])]

        # A deep memory is cut into columns of a block RAM each: synthesis would cut it into blocks of rows, and choose
        # between them behind.
        bits = len(Value.cast(read_1))
        width = bits if self._depth <= WIDE else max(1, BLOCK // self._depth)
        for k in range(0, bits, width):
            data = Value.cast(read_1)[k:k + width]
            # What is read of a row that is being written is not used, as the item that writes it is looked at. A port
            # with a register of its own would promise the old row all the same, at the price of logic behind it.
            memory = Memory(shape=len(data), depth=self._depth, init=[], attrs={"no_rw_check": 1})
            m.submodules[f"memory_{k}"] = memory
            read, write = memory.read_port(domain="comb"), memory.write_port()
            m.d.comb += [read.addr.eq(self.i.payload.address), write.addr.eq(done[1]["address"]),
                         write.data.eq(Value.cast(done[1]["row"])[k:k + width]), write.en.eq(done[1]["written"])]
            m.d.sync += data.eq(read.data)
        return m

    def _same_as(self, m, addresses, ahead, *, age):
        """Whether the item of an age has the address of the one ``ahead`` of it, computed a cycle before."""
        flag = Signal(name=f"same_as_{ahead}_ahead")
        m.d.sync += flag.eq(addresses[age - 1 + ahead] == addresses[age - 1])
        return flag
