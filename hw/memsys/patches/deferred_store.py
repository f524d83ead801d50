"""Deferred store: items that wait in chains, each chain for something else."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.queue import Queue
from hw.lib.validate import check_integer

__all__ = ["DeferredStore"]


class DeferredStore(wiring.Component):
    """Items that wait for the same data form a chain. The release of the chain sends the data with each of its items.

    The store is one linked list per chain in a shared memory, with one entry per item. The owner of a chain keeps the
    entries of its first and its last item.

    Parameters
    ----------
    shape
        Shape of the data.
    depth
        Items that can wait, at least 1.
    tag
        Shape of an item.

    Members
    -------
    i : In, stream of ``tag``, ``chain``
        An item, and the chain to whose end it is appended (``some`` 0: a new chain).
    longer : Out, ``chain``
        That chain with the item that is accepted in this cycle.
    i_release : In, stream of ``chain``, ``data``, always ready
        A chain that gets no more items, and its data.
    o : Out, stream of ``tag``, ``data``
        Items of released chains, one chain after the other, each from its first item.
    waiting : Out(range(depth + 1))
        Items in chains.
    releases : Out(1)
        Items of released chains have not left yet, or a chain is released in this cycle.

    Timing
    ------
    Latency: ``3`` cycles from ``i_release`` to the first item, if no other chain is being released. One item per cycle
    in and out, also from chain to chain; ``i`` stalls while the store is full.

    Raises
    ------
    TypeError
        The depth is no integer.
    ValueError
        The depth is out of range.
    """

    def __init__(self, shape, *, depth: int, tag):
        check_integer("Depth", depth, minimum=1)
        self._depth, self._tag = depth, tag
        #: Of ``chain`` in all streams.
        self.chain = StructLayout({"some": 1, "first": range(depth), "last": range(depth)})
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "chain": self.chain}))), "longer": Out(self.chain),
            "i_release": In(stream.Signature(StructLayout({"chain": self.chain, "data": shape}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "data": shape}))), "waiting": Out(range(depth + 1)),
            "releases": Out(1)})
        self.latency = 3

    def elaborate(self, platform):
        m = Module()
        entry = range(self._depth)
        # No entry is read while it is written.
        m.submodules.tags = tags = Memory(shape=self._tag, depth=self._depth, init=[], attrs={"no_rw_check": 1})
        m.submodules.behind = behind = Memory(shape=entry, depth=self._depth, init=[],
                                              attrs={"ram_style": "distributed"})
        tag_write, tag_read = tags.write_port(), tags.read_port(domain="comb")
        behind_write, behind_read = behind.write_port(), behind.read_port(domain="comb")

        # Entries that were never used, then those that became free.
        m.submodules.free = free = Queue(entry, depth=self._depth)
        unused, new, takes = Signal(range(self._depth + 1)), Signal(entry), Signal()
        recycles = unused == self._depth
        m.d.comb += [self.i.ready.eq(self.waiting != self._depth), takes.eq(self.i.valid & self.i.ready),
                     new.eq(Mux(recycles, free.o.payload, unused)), free.o.ready.eq(takes & recycles)]
        with m.If(takes & ~recycles):
            m.d.sync += unused.eq(unused + 1)

        chain = self.i.payload.chain
        m.d.comb += [self.longer.some.eq(1), self.longer.first.eq(Mux(chain.some, chain.first, new)),
                     self.longer.last.eq(new),
                     tag_write.addr.eq(new), tag_write.data.eq(self.i.payload.tag), tag_write.en.eq(takes),
                     behind_write.addr.eq(chain.last), behind_write.data.eq(new),
                     behind_write.en.eq(takes & chain.some)]

        walks = Signal()
        # Never full: each chain has an item at least.
        m.submodules.released = released = Queue(self.i_release.payload.shape(), depth=self._depth)
        claim(m, ~released.i.valid | released.i.ready, "a chain has an entry")
        m.d.comb += [
            released.i.valid.eq(self.i_release.valid), released.i.payload.eq(self.i_release.payload),
            self.releases.eq(self.i_release.valid | released.o.valid | walks | self.o.valid)]

        # The item that leaves next, and the one that is shown.
        at = Signal.like(released.o.payload, reset_less=True)
        shown = Signal.like(self.o.payload, reset_less=True)
        moves, leaves = Signal(), Signal()
        m.d.comb += [moves.eq(self.o.ready | ~self.o.valid), leaves.eq(walks & moves), self.o.payload.eq(shown),
                     tag_read.addr.eq(at.chain.first), behind_read.addr.eq(at.chain.first),
                     free.i.valid.eq(leaves), free.i.payload.eq(at.chain.first),
                     released.o.ready.eq(~walks | (leaves & (at.chain.first == at.chain.last)))]
        with m.If(released.o.ready):
            m.d.sync += [walks.eq(released.o.valid), at.eq(released.o.payload)]
        with m.Elif(leaves):
            m.d.sync += at.chain.first.eq(behind_read.data)
        with m.If(moves):
            m.d.sync += [self.o.valid.eq(walks), shown.tag.eq(tag_read.data), shown.data.eq(at.data)]
        count_entries(self.waiting)
        count_steps(m, self.waiting, up=takes, down=leaves, most=self._depth)
        return m
