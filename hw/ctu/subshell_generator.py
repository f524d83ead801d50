"""Subshell generator: a cluster's subshells one after the other, and the last one behind them."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.checks import count_steps
from hw.lib.queue import Queue

__all__ = ["ListError", "SubshellGenerator"]

# Entries that have been requested and have not left.
ENTRIES = 8


class ListError(enum.Enum, shape=2):
    """What was wrong with a list.

    LENGTH: it exceeds the table. PATCH: an entry names a patch that does not exist. SHELL: an entry's shell is 0.
    """

    NONE = 0
    LENGTH = 1
    PATCH = 2
    SHELL = 3


class SubshellGenerator(wiring.Component):
    """Reads the list, entry by entry, and appends the last subshell, all of the sector to the last shell.

    A faulty list ends before its first faulty entry: the last subshell follows at once, so the frustum is still cast,
    and ``error`` has the reason.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``first``, ``count``, ``patches``
        Begins a frustum: its list in the table, and the number of the scene's patches. Accepted when the last subshell
        of the frustum before has left.
    o_read : Out, stream of addresses; i_read : In, stream of ``patch``, ``shell``
        An address of the table, and its entry as in memory (`golden.engine.memory_map`, ``subshells``), in the order of
        the addresses.
    o : Out, stream of `CtuFormats.subshell`
        Subshells.
    error : Out, `ListError`
        The frustum's fault, from the last subshell on.

    Timing
    ------
    Latency: ``4`` cycles from ``i`` to the first subshell of a list, and the table's; 3 to the last one of an empty
    list, 2 from the list's end to the last one. An entry per cycle; 8 entries are in flight. A list begins a cycle
    after the last subshell of the one before.

    Golden counterpart: `golden.engine.cast.cluster_casting.ClusterCasting.schedule`. Source: Shen 1993, sections
    4.4.2.4 and 5.3.4.2.
    """

    def __init__(self, *, config: Config):
        formats = self._formats = CtuFormats(config)
        self._bits, self._table = config.ctu.subshell_bits, config.ctu.subshells
        # As wide as in memory.
        word = 32
        super().__init__({
            "i": In(stream.Signature(StructLayout({"first": word, "count": word, "patches": word}))),
            "o_read": Out(stream.Signature(self._bits)),
            "i_read": In(stream.Signature(StructLayout({"patch": word, "shell": word}))),
            "o": Out(stream.Signature(formats.subshell)), "error": Out(ListError)})

    def elaborate(self, platform):
        m = Module()
        formats, table = self._formats, self._table
        m.submodules.entries = entries = Queue(StructLayout({
            "patch": formats.patch, "shell": formats.shell, "no_patch": 1, "no_shell": 1}), depth=ENTRIES)
        given = Signal(self.i.payload.shape(), reset_less=True)
        too_long = Signal(reset_less=True)
        # The next address; entries not requested yet; entries requested that have not left.
        address, left, held = Signal(self._bits), Signal(self._bits + 1), Signal(range(ENTRIES + 1))
        requests, leaves = (stream.valid & stream.ready for stream in (self.o_read, entries.o))
        m.d.comb += self.o_read.payload.eq(address)
        with m.If(requests):
            m.d.sync += [address.eq(address + 1), left.eq(left - 1)]
        count_steps(m, held, up=requests, down=leaves, most=ENTRIES)

        # Entries are checked first: their fields are wider in memory than in the unit.
        read, checked, is_checked = self.i_read, Signal(entries.i.payload.shape(), reset_less=True), Signal()
        most = (1 << formats.shell.width) - 1
        m.d.comb += [read.ready.eq(1), entries.i.valid.eq(is_checked), entries.i.payload.eq(checked)]
        m.d.sync += [
            is_checked.eq(read.valid), checked.patch.eq(read.payload.patch),
            # Grid rays go no farther than the last shell anyway.
            checked.shell.eq(Mux(read.payload.shell > most, most, read.payload.shell)),
            checked.no_patch.eq(read.payload.patch >= given.patches), checked.no_shell.eq(read.payload.shell == 0)]
        entry, is_right = entries.o.payload, Signal()
        m.d.comb += [is_right.eq(~entry.no_patch & ~entry.no_shell),
                     self.o.payload.patch.eq(entry.patch), self.o.payload.shell.eq(entry.shell)]

        with m.FSM():
            with m.State("start"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [
                    given.eq(self.i.payload), address.eq(self.i.payload.first),
                    too_long.eq((self.i.payload.first > table) | (self.i.payload["count"] > table))]
                with m.If(self.i.valid):
                    m.d.sync += self.error.eq(ListError.NONE)
                    m.next = "length"
            with m.State("length"):
                beyond = given.first[:self._bits + 1] + given["count"][:self._bits + 1] > table
                with m.If(too_long | beyond):
                    m.d.sync += self.error.eq(ListError.LENGTH)
                with m.Else():
                    m.d.sync += left.eq(given["count"])
                m.next = "list"
            with m.State("list"):
                m.d.comb += [self.o_read.valid.eq((left != 0) & (held != ENTRIES)),
                             self.o.valid.eq(entries.o.valid & is_right), entries.o.ready.eq(self.o.ready | ~is_right)]
                with m.If(entries.o.valid & ~is_right):
                    m.d.sync += [left.eq(0), self.error.eq(Mux(entry.no_patch, ListError.PATCH, ListError.SHELL))]
                    m.next = "drain"
                with m.Elif((left == 0) & (held == 0)):
                    m.next = "last"
            with m.State("drain"):
                m.d.comb += entries.o.ready.eq(1)
                with m.If(held == 0):
                    m.next = "last"
            with m.State("last"):
                m.d.comb += [self.o.valid.eq(1), self.o.payload.patch.eq(0), self.o.payload.shell.eq(0),
                             self.o.payload.last.eq(1)]
                with m.If(self.o.ready):
                    m.next = "start"
        return m
