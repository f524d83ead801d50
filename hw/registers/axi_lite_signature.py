"""AXI4-Lite as a component's interface, by the standard's names."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["DATA_BITS", "AxiLiteSignature"]

DATA_BITS = 32


class AxiLiteSignature(wiring.Signature):
    """The five channels from the manager's side, with data of 32 bits.

    Parameters
    ----------
    address_bits
        Bits of the address of a byte.
    """

    def __init__(self, *, address_bits: int):
        members = {}
        for channel in "aw", "ar":
            members |= {f"{channel}addr": Out(address_bits), f"{channel}prot": Out(3), f"{channel}valid": Out(1),
                        f"{channel}ready": In(1)}
        super().__init__(members | {
            "wdata": Out(DATA_BITS), "wstrb": Out(DATA_BITS // 8), "wvalid": Out(1), "wready": In(1),
            "bresp": In(2), "bvalid": In(1), "bready": Out(1),
            "rdata": In(DATA_BITS), "rresp": In(2), "rvalid": In(1), "rready": Out(1)})
