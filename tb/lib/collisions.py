"""Memories whose collisions show: what is read of a word in the cycle in which it is written is not used.

The attribute ``no_rw_check`` tells synthesis so, and what a block RAM gives then is undefined. Simulators give the old
word, so a component that uses it would pass. Here the bits that are being written are read inverted.
"""

from amaranth.hdl import Cat, Fragment, MemoryInstance, Module, Signal, Value

__all__ = ["with_collisions"]


def with_collisions(component) -> Fragment:
    """A component for a simulator, with such memories."""
    return Fragment.get(component, _Platform())


class _Platform:
    """The platform whose memories are these."""

    def get_memory(self, memory):
        """The memory, for `amaranth.lib.memory.Memory.elaborate`."""
        m = Module()
        m.submodules.words = words = MemoryInstance(data=memory.data, attrs=memory.attrs)
        writes = {port: words.write_port(domain=port.domain, addr=port.addr, data=port.data, en=port.en)
                  for port in memory.write_ports}
        for number, port in enumerate(memory.read_ports):
            seen = Value.cast(port.data)
            data = Signal(len(seen), name=f"data_{number}") if "no_rw_check" in memory.attrs else seen
            words.read_port(domain=port.domain, addr=port.addr, data=data, en=port.en,
                            transparent_for=tuple(writes[write] for write in port.transparent_for))
            if data is seen:
                continue
            # A port without a clock has a register behind it.
            undefined = Signal(len(seen), name=f"undefined_{number}")
            collides = 0
            for write in memory.write_ports:
                step = len(seen) // max(1, len(write.en))
                written = Cat(bit.replicate(step) for bit in write.en)
                collides |= written & (write.addr == port.addr).replicate(len(seen))
            if port.domain == "comb":
                m.d.comb += undefined.eq(collides)
            else:
                with m.If(port.en):
                    m.d[port.domain] += undefined.eq(collides)
            m.d.comb += seen.eq(data ^ undefined)
        return m
