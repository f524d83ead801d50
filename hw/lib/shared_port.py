"""A write port that shares the address of a read port: a memory of two ports serves two readers and one writer."""

__all__ = ["share_port"]


def share_port(read, m, write, *, enable, address, data) -> None:
    """Connect a write port to a read port's address, which carries the write address while ``enable`` is 1.

    The data read in such a cycle are undefined. Call it after every other assignment to the read port's address; the
    memory has the attribute ``no_rw_check``.

    Parameters
    ----------
    read, write
        Ports of the same memory.
    m
        The component's module.
    enable, address, data
        The write.
    """
    with m.If(enable):
        m.d.comb += read.addr.eq(address)
    m.d.comb += [write.addr.eq(read.addr), write.en.eq(enable), write.data.eq(data)]
