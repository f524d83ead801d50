"""Queue state: whether the queue runs, halts, or resumes."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["QueueState"]


class QueueState(wiring.Component):
    """From ``run`` by ``drain`` or at once to ``stop``, then by ``abort`` to ``halted``, and by a resume to ``run``.

    A reset leads to ``stop`` from everywhere.

    Members
    -------
    resets, drains : In(1)
        An error that ends what is in flight, or the host stops it; one that lets it end.
    drained, memory_busy, aborted, loaded : In(1)
        Nothing is in flight; main memory has an outstanding transaction; each descriptor has its record; the load of a
        resume is over without an error.
    retry, copies : In(1)
        The host resumes the queue; the command's ``copies``.
    resumed : In(1)
        The load of a resume is over.
    run, drain, stop, abort, halted : Out(1)
        The state.
    live : Out(1)
        The queue runs or drains.
    resuming : Out(1)
        The host has resumed the queue, and it does not run yet.
    kept_copies : Out(1)
        ``copies`` of that command.

    Timing
    ------
    Latency: ``1`` cycle.
    """

    latency = 1

    def __init__(self):
        super().__init__({
            **{name: In(1) for name in ("resets", "drains", "drained", "memory_busy", "aborted", "loaded", "retry",
                                        "copies", "resumed")},
            **{name: Out(1) for name in ("run", "drain", "stop", "abort", "halted", "live", "resuming",
                                         "kept_copies")}})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.live.eq(self.run | self.drain)
        with m.FSM():
            for name, target, moves in (
                    ("run", "drain", self.drains), ("drain", "stop", self.drained),
                    ("stop", "abort", ~self.memory_busy), ("abort", "halted", self.aborted),
                    ("halted", "run", self.loaded)):
                with m.State(name.capitalize()):
                    m.d.comb += getattr(self, name).eq(1)
                    with m.If(moves):
                        m.next = target.capitalize()
                    if name != "stop":
                        with m.If(self.resets):
                            m.next = "Stop"
        with m.If(self.retry):
            m.d.sync += [self.resuming.eq(1), self.kept_copies.eq(self.copies)]
        with m.Elif(self.stop | self.resumed):
            m.d.sync += self.resuming.eq(0)
        return m
