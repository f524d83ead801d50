"""First in, first out: the solver marks one item, any item, and the proof tracks it through a component."""

from amaranth.hdl import Assert, Cover, Module, Signal, Value

__all__ = ["add_fifo_order"]


def add_fifo_order(m: Module, *, push, pushed, pop, popped, capacity: int, mark) -> Signal:
    """Assert that items leave unchanged and in order, that nothing else leaves, and that at most ``capacity`` items
    are inside. Cover that an item leaves that filled the component when it entered.

    Parameters
    ----------
    m
        The module of the proof.
    push, pushed
        An item enters in this cycle, and its payload.
    pop, popped
        An item that entered in an earlier cycle leaves, and its payload.
    capacity
        Largest number of items inside.
    mark
        A free input: track the item that enters in this cycle.

    Returns
    -------
    The number of items inside.
    """
    inside, ahead = (Signal(range(capacity + 2)) for _ in range(2))
    tracks, was_last = Signal(), Signal()
    value = Signal.like(Value.cast(pushed))
    m.d.sync += inside.eq(inside + push - pop)
    m.d.comb += Assert(inside <= capacity, "capacity")
    with m.If(pop):
        m.d.comb += Assert(inside != 0, "order")
    with m.If(tracks & pop):
        m.d.sync += ahead.eq(ahead - 1)
        with m.If(ahead == 0):
            m.d.sync += tracks.eq(0)
            m.d.comb += [Assert(Value.cast(popped) == value, "order"),
                         Cover(was_last & (value != 0), "the last entry leaves")]
    with m.If(mark & push & ~tracks):
        m.d.sync += [tracks.eq(1), value.eq(Value.cast(pushed)), ahead.eq(inside - pop),
                     was_last.eq(inside == capacity - 1)]
    return inside
