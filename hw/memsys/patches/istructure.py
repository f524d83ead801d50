"""I-structure memory: locations that are written once, and reads that wait for it."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.generations import Generations
from hw.lib.validate import check_integer
from hw.memsys.patches.deferred_store import DeferredStore

__all__ = ["IStructure"]


class IStructure(wiring.Component):
    """Each location is written once per version; a read of an empty location waits for the write.

    A location is present if its tag is the version's, so a new version empties all of them at once. Reads that wait for
    a location are a chain in the deferred store, first come, first released. A read that finds the store full stalls,
    and so do those behind it. Writes continue; the read continues when its own location is written.

    Reads and writes pass four stages side by side and take effect in the fourth. The first stage reads the memories;
    updates that take effect while the access is in flight are forwarded to it. So a read sees each write that was
    accepted in the same cycle or earlier, and a write releases each read that has not seen it.

    Parameters
    ----------
    shape
        Shape of the data.
    depth
        Locations, at least 1.
    version_bits
        Bits of the tag of a version, at least 1. After 2^b - 1 versions all tags are cleared.
    deferred
        Reads that can wait, at least 1.
    tag
        Shape of the tag of a read, which identifies its answer.
    renews
        A location may begin a version of its own (``i_renew``).

    Members
    -------
    i_start : In, stream without payload
        Begins a version, in which all locations are empty; needed after a reset too. Accepted when all reads of the
        last version have been answered; until then no other read is accepted.
    i_read : In, stream of ``address``, ``tag``
        Reads; the address is below ``depth``.
    i_write : In, stream of ``address``, ``data``
        Writes.
    i_renew : In, stream of addresses
        A location that becomes empty: it may be written once more. Reads that wait for it keep waiting. Reads that are
        accepted later see the renewal. It has priority over ``i_write``. Only with ``renews``.
    releases : Out(1)
        Writes are in flight, or reads that waited have not been answered yet. Only with ``renews``.
    o_read : Out, stream of ``tag``, ``data``
        One answer for each read; in any order, but with ``renews`` in the order of the reads of a location.
    o_refused : Out, stream of addresses, always ready
        Writes to a location that is present; its data stay.
    waiting : Out(range(deferred + 1))
        Reads in the deferred store.
    defers : Out(1)
        A read begins to wait.

    Timing
    ------
    Latency: ``5`` cycles from ``i_read`` to ``o_read`` of a location that is present, ``8`` from ``i_write`` to
    ``o_read`` of the first read that waits for it, ``4`` to ``o_refused``. One read and one write per cycle; releases
    come one per cycle without a gap, before reads of what is present. Reads stall with ``o_read`` and with a full
    store; with ``renews`` also while chains are released. Writes stall beside a renewal. Both stall while ``i_start``
    waits and no read does: until those in flight have been made and, every 2^``version_bits`` - 1 versions, for a sweep
    of ``depth`` cycles.

    Raises
    ------
    TypeError
        A size is no integer.
    ValueError
        A size is out of range.

    Golden counterpart: `golden.engine.memsys.patches.istructure.IStructure`. Source: Shen 1993, section 5.2.4.1.
    """

    def __init__(self, shape, *, depth: int, version_bits: int, deferred: int, tag, renews: bool = False):
        for name, value in (("Depth", depth), ("Version bits", version_bits), ("Deferred", deferred)):
            check_integer(name, value, minimum=1)
        self._shape, self._tag, self._renews = shape, tag, renews
        self._depth, self._version_bits, self._deferred = depth, version_bits, deferred

        def items(**layout):
            return stream.Signature(StructLayout(layout))

        super().__init__({
            "i_start": In(stream.Signature(0)),
            "i_read": In(items(address=range(depth), tag=tag)), "i_write": In(items(address=range(depth), data=shape)),
            "o_read": Out(items(tag=tag, data=shape)),
            "o_refused": Out(stream.Signature(range(depth), always_ready=True)), "waiting": Out(range(deferred + 1)),
            "defers": Out(1),
            **({"i_renew": In(stream.Signature(range(depth))), "releases": Out(1)} if renews else {})})
        self.latency = 5

    def elaborate(self, platform):
        m = Module()
        m.submodules.store = store = DeferredStore(self._shape, depth=self._deferred, tag=self._tag)
        m.submodules.generations = generations = Generations(bits=self._version_bits, depth=self._depth)
        version, sweeps, row = generations.generation, Signal(), Signal(range(self._depth))
        m.d.sync += [sweeps.eq(generations.sweeps), row.eq(generations.row)]

        # The state: what has happened to the location since the memories were read; in the last stage all of it.
        # ``known``: it has been written or renewed since; ``chain_known``: its chain has changed since.
        state = StructLayout({"known": 1, "present": 1, "data": self._shape, "chain_known": 1, "chain": store.chain})

        def stages(name, carried):
            access = StructLayout({"address": range(self._depth), "carried": carried, "state": state})
            return (Signal(4, name=f"{name}_there"),
                    [Signal(access, reset_less=True, name=f"{name}_{stage}") for stage in (1, 2, 3, 4)])

        read_there, reads = stages("read", self._tag)
        write_there, writes = stages("write", self._shape)
        read, write = reads[-1], writes[-1]

        # What takes effect in this cycle: an empty location is written, a location is renewed, a read begins to wait.
        # A location that may be renewed forgets its chain when the chain is released.
        written, defers, advances, renewed, forgets = Signal(), Signal(), Signal(), Signal(), Signal()

        def after(access, before):
            """The state of an access in flight after this cycle."""
            changed = Signal(state)
            m.d.comb += changed.eq(before)
            with m.If(written & self._meet(access, write)):
                m.d.comb += [changed.known.eq(1), changed.present.eq(1), changed.data.eq(write.carried)]
                if self._renews:
                    m.d.comb += [changed.chain_known.eq(1), changed.chain.some.eq(0)]
            if self._renews:
                with m.If(renewed & self._meet(access, write)):
                    m.d.comb += [changed.known.eq(1), changed.present.eq(0)]
            with m.If(defers & self._meet(access, read)):
                m.d.comb += [changed.chain_known.eq(1), changed.chain.eq(store.longer)]
            return changed

        def add_memory(name, contents, address, value, enable, empties):
            """A row per location, written in the last stage; what is read of it in that cycle is not used."""
            m.submodules[name] = memory = Memory(
                shape=StructLayout({"version": self._version_bits, "contents": contents}), depth=self._depth, init=[],
                attrs={"no_rw_check": 1})
            port = memory.write_port()
            m.d.comb += [port.addr.eq(Mux(sweeps, row, address)), port.data.contents.eq(value),
                         port.data.version.eq(Mux(sweeps | empties, 0, version)), port.en.eq(enable | empties | sweeps)]
            return memory

        def look_up(memory, access, enable):
            """Of the row of an access in stage 1, in stage 3: whether it is of this version, and what it says."""
            port = memory.read_port(domain="comb")
            arrives, found = (Signal.like(port.data, reset_less=True) for _ in range(2))
            m.d.comb += port.addr.eq(access.address)
            with m.If(enable):
                m.d.sync += [arrives.eq(port.data), found.eq(arrives)]
            return found.version == version, found.contents

        values = add_memory("values", self._shape, write.address, write.carried, written, renewed)
        presence = add_memory("presence", 0, write.address, 0, written, renewed)
        chains = add_memory("chains", store.chain, Mux(forgets, write.address, read.address), store.longer, defers,
                            forgets)

        def pass_stages(accesses, address, enable, memory):
            """Accesses in flight: from their stream to the last stage."""
            first, second, third, last = accesses
            merged, changed = Signal(state), after(third, third.state)
            m.d.comb += merged.eq(changed)
            present, data = look_up(memory, first, enable)
            waited_for, chain = look_up(chains, first, enable)
            with m.If(~changed.known):
                m.d.comb += [merged.present.eq(present), merged.data.eq(data)]
            with m.If(~changed.chain_known):
                m.d.comb += [merged.chain.eq(chain), merged.chain.some.eq(waited_for)]
            with m.If(enable):
                m.d.sync += [first.address.eq(address), second.eq(first), second.state.eq(after(first, 0)),
                             third.eq(second), third.state.eq(after(second, second.state)),
                             last.eq(third), last.state.eq(merged)]
            with m.Else():
                m.d.sync += [access.state.eq(after(access, access.state)) for access in (second, third)]

        # Writes.
        m.d.comb += [written.eq(write_there[-1] & ~write.state.present),
                     self.o_refused.valid.eq(write_there[-1] & write.state.present),
                     self.o_refused.payload.eq(write.address),
                     store.i_release.valid.eq(written & write.state.chain.some),
                     store.i_release.payload.chain.eq(write.state.chain),
                     store.i_release.payload.data.eq(write.carried)]
        m.d.sync += [write_there.eq((write_there << 1) | (self.i_write.valid & self.i_write.ready)),
                     writes[0].carried.eq(self.i_write.payload.data)]
        renew_there, written_address = Signal(4), self.i_write.payload.address
        if self._renews:
            m.d.sync += renew_there.eq((renew_there << 1) | (self.i_renew.valid & self.i_renew.ready))
            m.d.comb += [renewed.eq(renew_there[-1]), forgets.eq(store.i_release.valid)]
            written_address = Mux(self.i_renew.valid, self.i_renew.payload, written_address)
        pass_stages(writes, written_address, 1, presence)

        # Reads. One sees the write that takes effect beside it.
        meets, present, data = Signal(), Signal(), Signal(self._shape)
        moves, follows, shown = Signal(), Signal(), Signal.like(self.o_read.payload, reset_less=True)
        m.d.comb += [
            present.eq(read.state.present | (meets & written)),
            data.eq(Mux(read.state.present, read.state.data, write.carried)),
            store.i.valid.eq(read_there[-1] & ~present & ~forgets), store.i.payload.tag.eq(read.carried),
            store.i.payload.chain.eq(read.state.chain), defers.eq(store.i.valid & store.i.ready),
            self.defers.eq(defers),
            moves.eq(self.o_read.ready | ~self.o_read.valid), store.o.ready.eq(moves),
            advances.eq(~read_there[-1] | Mux(present, moves & ~follows, store.i.ready & ~forgets)),
            # A read of what may be renewed stays behind the reads that waited longer.
            follows.eq(store.releases if self._renews else store.o.valid),
            self.o_read.payload.eq(shown)]
        m.d.sync += meets.eq(Mux(advances, self._meet(reads[2], writes[2]), self._meet(read, writes[2])))
        with m.If(moves):
            m.d.sync += [self.o_read.valid.eq(store.o.valid | (read_there[-1] & present & ~follows)),
                         shown.tag.eq(read.carried), shown.data.eq(data)]
            with m.If(store.o.valid):
                m.d.sync += shown.eq(store.o.payload)
        with m.If(advances):
            m.d.sync += [read_there.eq((read_there << 1) | (self.i_read.valid & self.i_read.ready)),
                         reads[0].carried.eq(self.i_read.payload.tag)]
        pass_stages(reads, self.i_read.payload.address, advances, values)
        with m.If(~advances):
            m.d.sync += [read.state.present.eq(present), read.state.data.eq(data)]

        # Versions: a new one begins when no read waits, then no write is in flight.
        begun, drained, quiet, accepts = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [quiet.eq(drained & ~(write_there | renew_there).any()), self.waiting.eq(store.waiting),
                     generations.i_start.valid.eq(self.i_start.valid & quiet),
                     self.i_start.ready.eq(generations.i_start.ready & quiet),
                     self.i_read.ready.eq(advances & begun & ~self.i_start.valid),
                     accepts.eq(begun & ~drained),
                     self.i_write.ready.eq(accepts & ~self.i_renew.valid if self._renews else accepts)]
        if self._renews:
            m.d.comb += [self.i_renew.ready.eq(accepts), self.releases.eq(write_there.any() | store.releases)]
        m.d.sync += [drained.eq(self.i_start.valid & ~self.i_start.ready & ~read_there.any() & (store.waiting == 0)),
                     begun.eq(begun | (self.i_start.valid & self.i_start.ready))]
        return m

    def _meet(self, one, other):
        """Whether two accesses are of one location."""
        return one.address == other.address
