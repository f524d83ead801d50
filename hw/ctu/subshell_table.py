"""Subshell table: a cluster's subshell list."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["SubshellTable"]


class SubshellTable(wiring.Component):
    """Entries by their address; they stay until others are written.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of ``address``, ``patch``, ``shell``
        An address, and its entry as in memory (`golden.engine.memory_map`, ``subshells``). Always ready.
    i : In, stream of addresses; o : Out, stream of ``patch``, ``shell``
        An address, and its entry.

    Timing
    ------
    Latency: ``2`` cycles. An entry per cycle; stalls with ``o``, a cycle later.

    Golden counterpart: `golden.engine.memory_map.MemoryImage.subshells`.
    """

    def __init__(self, *, config: Config):
        address = config.ctu.subshell_bits
        entry = StructLayout({"patch": 32, "shell": 32})
        super().__init__({
            "i_load": In(stream.Signature(StructLayout({"address": address, "patch": 32, "shell": 32}),
                                          always_ready=True)),
            "i": In(stream.Signature(address)), "o": Out(stream.Signature(entry))})
        self._entries = Memory(shape=entry, depth=1 << address, init=[])
        # Whoever requests an entry sees a register of whether entries are taken.
        self._found = SkidBuffer(entry, bypass=True)
        self._pipeline = pipeline = Pipeline(self.i, self._found.i)
        read = pipeline.delay(pipeline.read(self._entries.read_port(), pipeline.input(self.i.payload)), 1)
        pipeline.output(self._found.i.payload, read)
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.entries = self._entries
        port, load = self._entries.write_port(), self.i_load
        m.d.comb += [port.addr.eq(load.payload.address), port.en.eq(load.valid),
                     *(port.data[name].eq(load.payload[name]) for name in ("patch", "shell"))]
        self._pipeline.add_to(m)
        m.submodules.found = self._found
        wiring.connect(m, self._found.o, wiring.flipped(self.o))
        return m
