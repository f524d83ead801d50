"""Cluster faults: the first fault of a cluster's units, until it is cleared."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.control_formats import ControlFormats
from hw.ctu.subshell_generator import ListError
from hw.lib.first_fault import FirstFault
from hw.memsys.patches.path_fault import PathFault
from hw.memsys.patches.path_formats import PathFormats
from hw.registers.error_code import LIST, PATH, ErrorCode

__all__ = ["ClusterFaults"]


class ClusterFaults(wiring.Component):
    """Latches the first fault of a cluster's units, or a time-out after it, which alone ends in a reset; of both in the
    same cycle the memory system's.

    The end of a faulty list is an event, reported once: that in the cycle of a clear is latched. The memory system
    latches its own fault, and clears it in the same cycle: what it holds then is an earlier one.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    memory : In(PathFormats.fault)
        Of the memory system, until ``clear``.
    ends : In(1)
        The traversal sends its final item.
    error : In(ListError)
        The fault of the frustum's list, at ``ends``.
    clear : In(1)
        Clears earlier faults.
    fault : Out(ControlFormats.fault)
        That fault, all 0 while there is none.

    Timing
    ------
    Latency: ``1`` cycle.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._fault = ControlFormats(config).fault
        super().__init__({"memory": In(PathFormats(config).fault), "ends": In(1), "error": In(ListError),
                          "clear": In(1), "fault": Out(self._fault)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.first_fault = first_fault = FirstFault(
            layout=self._fault, count=2, urgent=ErrorCode.PATH_TIMEOUT.value)
        memory, subshells = first_fault.i
        m.d.comb += [
            memory.valid.eq((self.memory.code != PathFault.NONE) & ~self.clear),
            memory.payload.code.eq(self.memory.code.as_value() + PATH), memory.payload.number.eq(self.memory.number),
            subshells.valid.eq(self.ends & (self.error != ListError.NONE)),
            subshells.payload.code.eq(self.error.as_value() + LIST),
            first_fault.clear.eq(self.clear), self.fault.eq(first_fault.o)]
        return m
