"""Engine whose memory port and registers have clocks of their own."""

from amaranth.hdl import ClockDomain, ClockSignal, DomainRenamer, Module, ResetSignal, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer, ResetSynchronizer
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.engine import Engine
from hw.lib.axi_crossing import AxiCrossing
from hw.memsys.port.axi_signature import AxiSignature
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.engine_registers import ADDRESS_BITS

__all__ = ["HELD", "AsyncEngine"]

# Edges of each clock for which a reset is held: one more than `ClockCrossing` needs.
HELD = 4


class AsyncEngine(wiring.Component):
    """An `Engine` between two `AxiCrossing`: the engine, main memory and the host have three unrelated clocks.

    A reset of any of them resets all three sides. It begins at once. After the last reset has ended, each clock has
    `HELD` edges more, so that the queues between them are reset in both domains; then it ends at each clock's second
    edge. Meanwhile no port is ready or valid, and offers are withdrawn in the middle of a cycle of other clocks: reset
    main memory and the host together with the engine, or while no access is in flight.

    Parameters
    ----------
    config
        The configuration.
    black_boxes
        Clusters are instances of a separately built module.

    Members
    -------
    m_axi_aclk, m_axi_aresetn : In(1) each
        Clock of ``axi``, and its reset, active low; it may begin at any time.
    s_axil_aclk, s_axil_aresetn : In(1) each
        The same of ``host`` and ``irq``.
    host : In, `AxiLiteSignature`
    axi : Out, `AxiSignature`
    irq : Out(1)
        Those of `Engine`.

    Timing
    ------
    ``sync`` is the engine's clock. Accesses of registers and of main memory are longer as `AxiCrossing` states; the
    rate of beats is that of the slower clock. ``irq`` is late by a cycle of ``sync`` and 2 of the host's clock.

    Golden counterpart: `golden.engine.jobs.run_job.run_job`.
    """

    def __init__(self, *, config: Config, black_boxes: bool = False):
        self._config, self._black_boxes = config, black_boxes
        super().__init__({
            **{f"{port}_{name}": In(1) for port in ("m_axi", "s_axil") for name in ("aclk", "aresetn")},
            "host": In(AxiLiteSignature(address_bits=ADDRESS_BITS)), "axi": Out(AxiSignature(config=config)),
            "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        clocks = {"core": ClockSignal(), "memory": self.m_axi_aclk, "host": self.s_axil_aclk}
        is_reset, held = ResetSignal() | ~self.m_axi_aresetn | ~self.s_axil_aresetn, Signal(len(clocks))
        for bit, (name, clock) in zip(held, clocks.items(), strict=True):
            m.domains += ClockDomain(name, local=True)
            m.d.comb += ClockSignal(name).eq(clock)
            m.submodules[f"held_{name}"] = AsyncFFSynchronizer(is_reset, bit, o_domain=name, stages=HELD)
            m.submodules[f"reset_{name}"] = ResetSynchronizer(is_reset | held.any(), domain=name)
        engine = Engine(config=self._config, black_boxes=self._black_boxes)
        m.submodules.engine = DomainRenamer("core")(engine)
        m.submodules.registers = registers = AxiCrossing(self.host.signature.flip(), manager="host",
                                                         subordinate="core")
        m.submodules.memory = memory = AxiCrossing(self.axi.signature, manager="core", subordinate="memory")
        # A term of two bits that change together: a register keeps its glitches from the host.
        irq = Signal()
        m.d.core += irq.eq(engine.irq)
        m.submodules.irq = FFSynchronizer(irq, self.irq, o_domain="host")
        wiring.connect(m, wiring.flipped(self.host), registers.i)
        wiring.connect(m, registers.o, engine.host)
        wiring.connect(m, engine.axi, memory.i)
        wiring.connect(m, memory.o, wiring.flipped(self.axi))
        return m
