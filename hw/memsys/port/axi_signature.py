"""AXI4 as a component's interface, by the standard's names."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["AxiSignature"]


class AxiSignature(wiring.Signature):
    """The five channels from the manager's side. All bursts are of type INCR and of full beats.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, *, config: Config):
        memory, formats = config.memory, MemoryFormats(config)
        members = {}
        for channel in "aw", "ar":
            members |= {f"{channel}id": Out(formats.slot_bits), f"{channel}addr": Out(memory.address_bits),
                        f"{channel}len": Out(8), f"{channel}size": Out(3), f"{channel}burst": Out(2),
                        f"{channel}cache": Out(4), f"{channel}prot": Out(3), f"{channel}valid": Out(1),
                        f"{channel}ready": In(1)}
        super().__init__(members | {
            "wdata": Out(memory.data_bits), "wstrb": Out(memory.beat_bytes), "wlast": Out(1), "wvalid": Out(1),
            "wready": In(1),
            "bid": In(formats.slot_bits), "bresp": In(2), "bvalid": In(1), "bready": Out(1),
            "rid": In(formats.slot_bits), "rdata": In(memory.data_bits), "rresp": In(2), "rlast": In(1),
            "rvalid": In(1), "rready": Out(1)})
