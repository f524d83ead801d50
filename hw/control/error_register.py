"""Error register: the first error of the machine."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.control_formats import DOORBELL_BITS, ControlFormats
from hw.control.job_formats import JobFormats
from hw.registers.error_code import ErrorCode

__all__ = ["ErrorRegister"]


class ErrorRegister(wiring.Component):
    """Keeps the first error until it is cleared; those of the cycle of a clear come after it.

    Of errors of one cycle the first of these: watchdog, record, load of a resume, cluster, network, ring, doorbell,
    command.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    clear : In(1)
        Clears it.
    culprit : In(JobFormats.culprit)
        `ClusterWatch`'s.
    record, load, ring : In(ControlFormats.fault)
        A record was not written; the load of a resume has failed; the ring could not be read. Each counts with
        ``record_fails``, ``load_fails`` and ``ring_fails``.
    record_fails, load_fails, ring_fails : In(1)
        See there.
    is_far : In(1)
        The ``doorbell`` is too far ahead.
    doorbell : In(32)
        The register.
    wrong : In(1)
        A command is not possible.
    error : Out(ControlFormats.error)
        The first error.

    Timing
    ------
    Latency: ``1`` cycle.
    """

    latency = 1

    def __init__(self, *, config: Config):
        control = ControlFormats(config)
        super().__init__({
            "clear": In(1), "culprit": In(JobFormats(config).culprit),
            **{name: In(control.fault) for name in ("record", "load", "ring")},
            **{name: In(1) for name in ("record_fails", "load_fails", "ring_fails", "is_far", "wrong")},
            "doorbell": In(DOORBELL_BITS), "error": Out(control.error)})

    def elaborate(self, platform):
        m = Module()
        error, culprit, found = self.error, self.culprit, Signal.like(self.error)
        blames = [found[name].eq(culprit[name]) for name in ("code", "cluster", "number")]

        def reports(fault):
            return [found.code.eq(fault.code), found.number.eq(fault.number)]

        with m.If(culprit.code == ErrorCode.WATCHDOG):
            m.d.comb += blames
        with m.Elif(self.record_fails):
            m.d.comb += reports(self.record)
        with m.Elif(self.load_fails):
            m.d.comb += reports(self.load)
        with m.Elif(culprit.code != ErrorCode.NONE):
            m.d.comb += blames
        with m.Elif(self.ring_fails):
            m.d.comb += reports(self.ring)
        with m.Elif(self.is_far):
            m.d.comb += [found.code.eq(ErrorCode.RING), found.number.eq(self.doorbell)]
        with m.Elif(self.wrong):
            m.d.comb += found.code.eq(ErrorCode.COMMAND)
        with m.If(self.clear | (error.code == ErrorCode.NONE)):
            m.d.sync += error.eq(found)
        return m
