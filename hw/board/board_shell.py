"""Board shell: an engine with main memory, a host and a serial line."""

from amaranth.hdl import ClockDomain, ClockSignal, DomainRenamer, Module, ResetSignal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.board.block_memory import BlockMemory
from hw.board.program import Program
from hw.board.sequencer import Sequencer
from hw.board.uart_transmitter import UartTransmitter
from hw.engine import Engine
from hw.memsys.bus.cache_policy import CachePolicy

__all__ = ["BoardShell"]


class BoardShell(wiring.Component):
    """After reset casts the frustum of the job in its memory, and sends the results.

    ::

        Sequencer - registers, interrupt - Engine - AXI4 - BlockMemory
            |'- bytes - UartTransmitter - tx                    |
            '----------------------- beats ---------------------'

    ``again`` resets engine and memory, not the memory's contents: what the program finds is the same each time.

    Parameters
    ----------
    config
        The configuration. Only its own policy of the caches is built.
    program
        The sequence, and the contents of main memory (`radiosity.flow.board.record`).
    divisor
        Cycles of a bit of the serial line.
    black_boxes
        See `Engine`.

    Members
    -------
    tx : Out(1)
        The serial line: frames, see `hw.board.frame`.
    again : In(1)
        Cast and send once more, after the end.
    busy, failed : Out(1)
        See `Sequencer`.

    Timing
    ------
    See the units. Most of the time goes into sending.
    """

    def __init__(self, *, config: Config, program: Program, divisor: int, black_boxes: bool = False):
        self._config, self._program, self._divisor, self._black_boxes = config, program, divisor, black_boxes
        super().__init__({"tx": Out(1, init=1), "again": In(1), "busy": Out(1), "failed": Out(1)})

    def elaborate(self, platform):
        m = Module()
        config = self._config
        engine = Engine(config=config, black_boxes=self._black_boxes,
                        policies=(CachePolicy[config.memsys.cache_policy.upper()],))
        memory = BlockMemory(config=config, data=self._program.memory)
        m.domains.machine = machine = ClockDomain(local=True)
        m.submodules.engine, m.submodules.memory = (DomainRenamer("machine")(part) for part in (engine, memory))
        m.submodules.sequencer = sequencer = Sequencer(config=config, program=self._program)
        m.submodules.uart = uart = UartTransmitter(divisor=self._divisor)
        wiring.connect(m, sequencer.host, engine.host)
        wiring.connect(m, engine.axi, memory.axi)
        wiring.connect(m, sequencer.o_peek, memory.i_peek)
        wiring.connect(m, memory.o_peek, sequencer.i_peek)
        wiring.connect(m, sequencer.o, uart.i)
        # Boards need not have a reset.
        reset = ResetSignal(allow_reset_less=True)
        m.d.comb += [machine.clk.eq(ClockSignal()), machine.rst.eq(reset | sequencer.restarts),
                     sequencer.irq.eq(engine.irq), sequencer.again.eq(self.again), self.tx.eq(uart.tx),
                     self.busy.eq(sequencer.busy), self.failed.eq(sequencer.failed)]
        return m
