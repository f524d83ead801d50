"""Memory systems of several clusters with all that is between them and main memory: network, bus, caches and port."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.axi_signature import AxiSignature
from hw.memsys.main_memory_port import MainMemoryPort
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.system_bus_interface import READERS
from hw.noc.patch_network import PatchNetwork
from tb.memsys.memory_path import MemoryPath

__all__ = ["JoinedPath"]

# By port of the path the network's.
FROM_PATH = {"o_request": "i_request", "o_remote": "i_reply"}
TO_PATH = {"i_remote": "o_request", "i_reply": "o_reply"}
TO_MEMORY = ("o_read", "i_read")


class JoinedPath(wiring.Component):
    """As `MemoryPath`, one cluster for each node of the configuration's network; nothing but memory is left outside.

    Members
    -------
    axi, window
        Of `MainMemoryPort`; nothing is written.
    memory_fault, network_fault
        What went wrong there.
    """

    def __init__(self, *, config: Config):
        self._config = config
        self.path = MemoryPath(config=config, clusters=config.noc.nodes)
        self.network = PatchNetwork(config=config)
        self.port = MainMemoryPort(config=config, tag=range(READERS))
        formats, members = MemoryFormats(config), self.path.signature.members
        super().__init__({
            **{name: member for name, member in members.items() if name not in (*FROM_PATH, *TO_PATH, *TO_MEMORY)},
            "axi": Out(AxiSignature(config=config)), "window": In(formats.window),
            "memory_fault": Out(formats.fault), "network_fault": self.network.signature.members["fault"]})

    def elaborate(self, platform):
        """Path, network and port."""
        m = Module()
        m.submodules.path, m.submodules.network, m.submodules.port = path, network, port = (
            self.path, self.network, self.port)
        for node in range(self._config.noc.nodes):
            for out, given in FROM_PATH.items():
                wiring.connect(m, getattr(path, out)[node], getattr(network, given)[node])
            for given, out in TO_PATH.items():
                wiring.connect(m, getattr(network, out)[node], getattr(path, given)[node])
            m.d.comb += self.network_fault[node].eq(network.fault[node])
        wiring.connect(m, path.o_read, port.i_read)
        wiring.connect(m, port.o_read, path.i_read)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))
        m.d.comb += [port.read_window.eq(self.window), self.memory_fault.eq(port.fault)]
        for name, member in self.path.signature.members.items():
            if name in self.signature.members:
                self._pass_on(m, member, getattr(self, name), getattr(path, name))
        return m

    def _pass_on(self, m, member, outside, inside):
        """A port of the path, element by element."""
        if member.dimensions:
            for one, other in zip(outside, inside, strict=True):
                self._pass_on(m, (In if member.flow is In else Out)(
                    member.signature if member.is_signature else member.shape), one, other)
        elif member.is_signature:
            outside = wiring.flipped(outside)
            wiring.connect(m, *((outside, inside) if member.flow is In else (inside, outside)))
        else:
            m.d.comb += inside.eq(outside) if member.flow is In else outside.eq(inside)
