"""The other end of a serial line in the simulator."""

import cocotb
from cocotb.triggers import FallingEdge, Timer

from tb.lib.clocking import PERIOD

__all__ = ["SerialLine"]


class SerialLine:
    """Receives bytes: 8 data bits, no parity, one stop bit.

    Parameters
    ----------
    line
        The signal.
    divisor
        Cycles of a bit.

    Members
    -------
    received
        All that came.
    """

    def __init__(self, line, *, divisor: int):
        self._line, self._bit = line, divisor * PERIOD
        self.received = bytearray()
        cocotb.start_soon(self._run())

    async def _run(self):
        line, edge = self._line, FallingEdge(self._line)
        # In the middle of bits.
        first, bit = Timer(3 * self._bit // 2, unit="ns"), Timer(self._bit, unit="ns")
        while True:
            await edge
            await first
            value = 0
            for number in range(8):
                value |= int(line.value) << number
                await bit
            assert int(line.value), "the stop bit must be 1"
            self.received.append(value)
