"""A write port that takes a read port's place, so that a memory of two ports serves two readers and who fills it."""

__all__ = ["write_in_place_of"]


def write_in_place_of(read, m, write, *, enable, address, data) -> None:
    """Drive a write port with the address of a read port, which is its own while it writes.

    What is read in such a cycle means nothing. To be called after all else that drives the read port's address; the
    memory is one with ``no_rw_check``.

    Parameters
    ----------
    read, write
        Ports of the same memory.
    m
        The component's module.
    enable, address, data
        What is written.
    """
    with m.If(enable):
        m.d.comb += read.addr.eq(address)
    m.d.comb += [write.addr.eq(read.addr), write.en.eq(enable), write.data.eq(data)]
