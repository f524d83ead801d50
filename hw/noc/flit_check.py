"""Check bits of flits."""

from amaranth.hdl import Cat, Value

from hw.noc.noc_tables import CHECK_BITS, check

__all__ = ["check_of"]


def check_of(method: str, value: Value) -> Value:
    """The check bits of a value, `golden.engine.noc.packing.check`: each is the sum of some of its bits, modulo 2."""
    value = Value.cast(value)
    # The check is linear: it is the sum of the checks of the single bits.
    alone = [check(method, 1 << position, len(value)) for position in range(len(value))]
    return Cat(Cat(value[position] for position, its in enumerate(alone) if its >> bit & 1).xor()
               for bit in range(CHECK_BITS[method]))
