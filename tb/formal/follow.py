"""First in, first out: one item, any item, is followed through a component."""

from amaranth.hdl import Assert, Cover, Module, Signal, Value

__all__ = ["follow"]


def follow(m: Module, enters, item, leaves, gone, *, room: int, marks) -> Signal:
    """Asserts that what enters leaves unchanged and in order, that nothing else does, and that no more than ``room``
    items are inside. Covers that an item leaves which had entered as the last one that there was room for.

    Parameters
    ----------
    m
        Where it all goes.
    enters, item
        An item enters in this cycle, and which.
    leaves, gone
        One that entered in an earlier cycle leaves, and which.
    room
        Items inside at most.
    marks
        A free input: the item that enters now is the one to follow.

    Returns
    -------
    How many items are inside.
    """
    inside, ahead = (Signal(range(room + 2)) for _ in range(2))
    follows, was_last = Signal(), Signal()
    value = Signal.like(Value.cast(item))
    m.d.sync += inside.eq(inside + enters - leaves)
    m.d.comb += Assert(inside <= room)
    with m.If(leaves):
        m.d.comb += Assert(inside != 0)
    with m.If(follows & leaves):
        m.d.sync += ahead.eq(ahead - 1)
        with m.If(ahead == 0):
            m.d.sync += follows.eq(0)
            m.d.comb += [Assert(Value.cast(gone) == value), Cover(was_last & (value != 0))]
    with m.If(marks & enters & ~follows):
        m.d.sync += [follows.eq(1), value.eq(Value.cast(item)), ahead.eq(inside - leaves),
                     was_last.eq(inside == room - 1)]
    return inside
