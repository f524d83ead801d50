"""Patch store: a cluster's copies of the patches that other clusters or main memory hold."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memsys.patches.patch_store import KEPT_OF
from hw.formats import Formats
from hw.lib.checks import claim, count_entries
from hw.lib.generations import Generations
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue
from hw.lib.validate import check_power_of_two
from hw.memsys.patches.istructure import IStructure
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.patches.void_check import VERTICES, VoidCheck

__all__ = ["PatchStore"]

# Versions of the presence bits and of the tags before a sweep.
VERSION_BITS = 4


class PatchStore(wiring.Component):
    """Fetches each patch once for all requests that wait for it, and keeps some of them.

    ::

        i - tags -+- o_fetch                       i_fill, i_lost - frames -+- IStructure - o_stored
                  '- IStructure (renew, read)                               '- o_passed

    Patch p belongs into frame p modulo ``frames``. A request finds its patch in the frame, or in flight to it: then it
    waits in the `IStructure` without another fetch. Otherwise the patch is fetched. It is kept if the frame is empty,
    and at every `KEPT_OF`-th request that meets another patch there: each frustum needs about the same patches, more
    than the frames, in about the same order, so a patch that each miss replaces would be gone before its next request.
    What is not kept is passed on. A frame with a request in flight is not renewed: the request waits for its last
    answer. A fill never stalls but with ``o_passed``.

    A patch whose vertices are all 0 comes from a cluster that does not hold it, see `VoidCheck`. It is answered and not
    kept, so a later frustum fetches it again.

    Parameters
    ----------
    config
        The configuration.
    frames
        Patches that are kept, a power of two, at least 2.
    requests
        Requests in flight, a power of two, at least 2.

    Members
    -------
    i_start : In, stream without payload
        Empties the store, needed after a reset too. Accepted when no request is in flight.
    i : In, stream of `PathFormats.store_request`
        Requests. Accepted while fewer than ``requests`` are in flight.
    o_fetch : Out, stream of `PathFormats.store_request`
        Patches to fetch, in the order of their requests.
    i_fill : In, stream of `Formats.patch_vertex`
        Fetched patches in any order; the four vertices of a patch one after the other.
    i_lost : In, stream of a patch id
        A fetch that has failed. Not between the vertices of a patch.
    o_stored : Out, stream of `Formats.patch_vertex`
        Patches from their frames.
    o_passed : Out, stream of `Formats.patch_vertex`
        Patches that were not kept. Each request is answered at one of both, or lost.
    lost : Out(2)
        Requests that end without a patch, a bit for each; the fetch has failed. The frame keeps nothing.
    hits : Out(32)
        Requests without a fetch, since reset.
    deferred : Out(32)
        Requests that have waited in the `IStructure`, since reset.

    Timing
    ------
    A request every three cycles, unless it waits for its frame, so a patch every four. Latency: ``10`` cycles from a
    request whose patch is kept to its first vertex, ``3`` from a request to ``o_fetch``. Fills come at one vertex per
    cycle.

    Raises
    ------
    TypeError
        A number is no integer.
    ValueError
        A number is no power of two, or too small.

    Golden counterpart: `golden.engine.memsys.patches.patch_store.PatchStore`. Source: Shen 1993, section 5.2.4.1, for
    the I-structure.
    """

    latency = 10

    def __init__(self, *, config: Config, frames: int, requests: int = 16):
        check_power_of_two("Frames", frames, minimum=2)
        check_power_of_two("Requests", requests, minimum=2)
        self._config, self._frames, self._requests = config, frames, requests
        self._formats = formats = Formats(config)
        request = PathFormats(config).store_request
        vertices = stream.Signature(formats.patch_vertex)
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(request)),
            "o_fetch": Out(stream.Signature(request)), "i_fill": In(vertices),
            "i_lost": In(stream.Signature(formats.patch)), "o_stored": Out(vertices), "o_passed": Out(vertices),
            "lost": Out(2), "hits": Out(32), "deferred": Out(32)})
        # Entries in flight; the memory system checks that all are free when a frustum begins.
        self.taken = Signal(requests)
        # A request in flight, from its lookup until its last vertex has left.
        self._entry = StructLayout({"patch": formats.patch, "frame": range(frames), "is_stored": 1})
        self._number = range(requests)
        # What the I-structure keeps of a patch: its fetch has failed; its vertices are all 0.
        self._head = StructLayout({"is_lost": 1, "is_void": 1})
        # A vertex in its frame.
        self._vertex = StructLayout({"vertex": formats.scene_vector, "surface": formats.surface})

    def elaborate(self, platform):
        m = Module()
        entries = Signal(ArrayLayout(self._entry, self._requests), reset_less=True)
        taken, fetching, frees = self.taken, *(Signal(self._requests, name=name) for name in ("fetching", "frees"))
        m.submodules.istructure = presence = IStructure(
            self._head, depth=self._frames, version_bits=VERSION_BITS, deferred=self._requests, tag=self._number,
            renews=True)
        m.submodules.generations = generations = Generations(bits=VERSION_BITS, depth=self._frames)
        row = StructLayout({"generation": VERSION_BITS, "patch": self._formats.patch})
        m.submodules.tags = tags = Memory(shape=row, depth=self._frames, init=[], attrs={"no_rw_check": 1})
        m.submodules.vertices = vertices = Memory(
            shape=self._vertex, depth=VERTICES * self._frames, init=[], attrs={"no_rw_check": 1})
        # Frames that lose their tag.
        forgets = stream.Signature(range(self._frames)).create()
        m.d.sync += [self.lost.eq(0), self.deferred.eq(self.deferred + presence.defers)]
        looks = Signal()
        begun = self._add_start(m, generations, presence, looks | taken.any())
        looked_up, fetched = self._add_lookup(m, entries=entries, taken=taken, tags=tags, generations=generations,
                                              presence=presence, forgets=forgets, begun=begun, looks=looks)
        filled, passed = self._add_fills(m, entries=entries, fetching=fetching, vertices=vertices, presence=presence)
        read = self._add_answers(m, entries=entries, vertices=vertices, presence=presence, forgets=forgets)
        m.d.comb += frees.eq(passed | read)
        count_entries(sum(taken))
        claim(m, ~presence.o_refused.valid, "what is written was absent")
        claim(m, (fetching & ~taken) == 0, "what is fetched has an entry")
        claim(m, (frees & ~taken) == 0, "an entry is freed once")
        m.d.sync += [taken.eq((taken | looked_up) & ~frees), fetching.eq((fetching | fetched) & ~filled)]
        return m

    def _add_start(self, m, generations, presence, in_flight):
        """Tags and presence bits begin together; returns whether they have."""
        begun = Signal()
        waits = {name: Signal(name=f"{name}_waits") for name in ("tags", "presence")}
        starts = Signal()
        for name, start in (("tags", generations.i_start), ("presence", presence.i_start)):
            m.d.comb += start.valid.eq(waits[name])
            with m.If(start.ready):
                m.d.sync += waits[name].eq(0)
        m.d.comb += self.i_start.ready.eq(starts & ~waits["tags"] & ~waits["presence"])
        with m.If(self.i_start.valid & ~starts & ~in_flight):
            m.d.sync += [starts.eq(1), *(wait.eq(1) for wait in waits.values())]
        with m.If(self.i_start.ready):
            m.d.sync += [starts.eq(0), begun.eq(1)]
        return begun

    def _add_lookup(self, m, *, entries, taken, tags, generations, presence, forgets, begun, looks):
        """From a request to its entry, its fetch and its read; returns the entry that it takes, and the same if it is
        fetched, one-hot.
        """
        request, frame_bits = Signal.like(self.i.payload), self._frames.bit_length() - 1
        frame, free, number = Signal(range(self._frames)), Signal(self._requests), Signal(self._number)
        matches, empty, in_use, looked_up = Signal(), Signal(), Signal(), Signal(self._requests)
        # Requests that have met another patch, since the store was emptied.
        conflicts = Signal(range(KEPT_OF))
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += conflicts.eq(0)
        read, write = tags.read_port(), tags.write_port()
        # The lowest free entry.
        m.d.comb += [frame.eq(request.patch[:frame_bits]), free.eq(~taken & (taken + 1)[:self._requests]),
                     read.addr.eq(self.i.payload.patch[:frame_bits])]
        m.submodules.fetches = fetches = Queue(self.i.payload.shape(), depth=self._requests)
        access = StructLayout({"frame": range(self._frames), "entry": self._number})
        m.submodules.accesses = accesses = Queue(access, depth=self._requests)
        wiring.connect(m, fetches.o, wiring.flipped(self.o_fetch))
        # Registered: what a request meets is known in the third cycle, and no other request is looked up meanwhile.
        # ``in_use`` lags behind by a cycle, in which a frame can only become free.
        uses = [taken[k] & entries[k].is_stored & (entries[k].frame == frame) for k in range(self._requests)]
        keeps, renews, acts = Signal(), Signal(), Signal()
        m.d.sync += in_use.eq(Cat(uses).any())
        m.d.comb += [
            renews.eq(~matches & (empty | (conflicts == KEPT_OF - 1))), keeps.eq(matches | renews),
            fetches.i.payload.eq(request), accesses.i.payload.frame.eq(frame), accesses.i.payload.entry.eq(number),
            write.addr.eq(Mux(generations.sweeps, generations.row, Mux(acts, frame, forgets.payload))),
            write.data.patch.eq(request.patch),
            write.data.generation.eq(Mux(acts, generations.generation, 0)),
            write.en.eq(generations.sweeps | (forgets.valid & forgets.ready) | (acts & renews))]
        # The frame of a lost patch is forgotten between two lookups, and while one waits for its frame.
        m.d.comb += looks.eq(1)
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [looks.eq(0), self.i.ready.eq(begun & ~taken.all() & ~self.i_start.valid & ~forgets.valid),
                             forgets.ready.eq(~generations.sweeps)]
                m.d.sync += request.eq(self.i.payload)
                with m.If(self.i.valid & self.i.ready):
                    m.next = "Compare"
            with m.State("Compare"):
                m.d.sync += [
                    matches.eq((read.data.generation == generations.generation) & (read.data.patch == request.patch)),
                    empty.eq(read.data.generation != generations.generation),
                    number.eq(sum(Mux(free[k], k, 0) for k in range(self._requests)))]
                m.next = "Act"
            # A fill cannot come before its frame has been renewed, however long reads stall.
            with m.State("Act"):
                m.d.comb += [presence.i_renew.valid.eq(renews & ~in_use), forgets.ready.eq(~generations.sweeps & ~acts),
                             acts.eq(~renews | (presence.i_renew.ready & ~in_use))]
                with m.If(acts):
                    m.d.comb += [looked_up.eq(1 << number), fetches.i.valid.eq(~matches), accesses.i.valid.eq(keeps)]
                    m.d.sync += [
                        entries[number].patch.eq(request.patch), entries[number].frame.eq(frame),
                        entries[number].is_stored.eq(keeps), self.hits.eq(self.hits + matches),
                        conflicts.eq(conflicts + (~matches & ~empty))]
                    m.next = "Wait"
        first = accesses.o.payload
        m.d.comb += [
            presence.i_renew.payload.eq(frame), presence.i_read.valid.eq(accesses.o.valid),
            accesses.o.ready.eq(presence.i_read.ready), presence.i_read.payload.address.eq(first.frame),
            presence.i_read.payload.tag.eq(first.entry)]
        return looked_up, Mux(matches, 0, looked_up)

    def _add_fills(self, m, *, entries, fetching, vertices, presence):
        """Vertices of a fetched patch into its frame, or on to ``o_passed``; returns the entry whose fetch ends, and
        the same if it is passed on or lost, one-hot.
        """
        fill = StructLayout({"frame": range(self._frames), "head": self._head})
        m.submodules.fills = fills = Queue(fill, depth=self._requests)
        write = vertices.write_port()
        # A vertex waits a cycle for the entry of its patch.
        vertex, there, is_lost = Signal.like(self.i_fill.payload, reset_less=True), Signal(), Signal()
        found, advances, ends = Signal(self._requests), Signal(), Signal()
        m.submodules.check = check = VoidCheck(config=self._config)
        patch = Mux(self.i_lost.valid, self.i_lost.payload, self.i_fill.payload.patch)
        first = Signal(range(VERTICES))
        takes_lost, takes = Signal(), Signal()
        m.d.comb += [
            takes_lost.eq(self.i_lost.valid & (first == 0)), self.i_lost.ready.eq(advances & (first == 0)),
            self.i_fill.ready.eq(advances & ~takes_lost), takes.eq(self.i_fill.valid & ~takes_lost)]
        with m.If(takes & self.i_fill.ready):
            m.d.sync += first.eq(first + 1)
        # Of several fetches of a patch any one is served.
        candidates, filled = Signal(self._requests), Signal(self._requests)
        each = [entries[k] for k in range(self._requests)]
        m.d.comb += [filled.eq(Mux(ends, found, 0)),
                     candidates.eq(Cat(entry.patch == patch for entry in each) & fetching & ~filled)]
        claim(m, ~advances | ~(takes_lost | (takes & (first == 0))) | candidates.any(), "what comes is being fetched")
        with m.If(advances):
            m.d.sync += [there.eq(takes_lost | takes), is_lost.eq(takes_lost), vertex.eq(self.i_fill.payload)]
            with m.If(takes_lost | (first == 0)):
                m.d.sync += found.eq(candidates & ~(candidates - 1))
        entry = Signal(self._entry)
        for k in range(self._requests):
            with m.If(found[k]):
                m.d.comb += entry.eq(entries[k])
        moves = there & advances
        m.d.comb += [
            check.vertex.eq(vertex.vertex), check.moves.eq(moves & ~is_lost),
            ends.eq(moves & (is_lost | (check.index == VERTICES - 1))),
            write.addr.eq(Cat(check.index, entry.frame)), write.data.vertex.eq(vertex.vertex),
            write.data.surface.eq(vertex.surface),
            write.en.eq(moves & entry.is_stored & ~is_lost),
            fills.i.valid.eq(ends & entry.is_stored), fills.i.payload.frame.eq(entry.frame),
            fills.i.payload.head.is_lost.eq(is_lost), fills.i.payload.head.is_void.eq(check.void),
            self.o_passed.valid.eq(there & ~entry.is_stored & ~is_lost), self.o_passed.payload.eq(vertex),
            advances.eq(~self.o_passed.valid | self.o_passed.ready)]
        m.d.comb += [
            presence.i_write.valid.eq(fills.o.valid), fills.o.ready.eq(presence.i_write.ready),
            presence.i_write.payload.address.eq(fills.o.payload.frame),
            presence.i_write.payload.data.eq(fills.o.payload.head)]
        with m.If(ends & is_lost & ~entry.is_stored):
            m.d.sync += self.lost[0].eq(1)
        return filled, Mux(entry.is_stored, 0, filled)

    def _add_answers(self, m, *, entries, vertices, presence, forgets):
        """What has come into a frame is read for each request that waits for it; returns the entry, one-hot."""
        step = StructLayout({"index": range(VERTICES), "frame": range(self._frames), "patch": self._formats.patch})
        steps = stream.Signature(step).create(path=("steps",))
        pipeline = Pipeline(steps, self.o_stored)
        given, out = steps.payload, self.o_stored.payload
        address = pipeline.combine(lambda index, frame: Cat(index, frame), pipeline.input(given.index),
                                   pipeline.input(given.frame))
        read = pipeline.delay(pipeline.read(vertices.read_port(), address), 1)
        for axis in range(3):
            pipeline.output(out.vertex[axis], pipeline.combine(lambda read, axis=axis: read.vertex[axis], read))
        pipeline.output(out.surface, pipeline.combine(lambda read: read.surface, read))
        pipeline.output(out.patch, pipeline.input(given.patch))
        pipeline.add_to(m)

        answer, index, ends = presence.o_read, Signal(range(VERTICES)), Signal()
        entry, head, is_last = Signal(self._entry), answer.payload.data, index == VERTICES - 1
        # What leaves a frame without a patch leaves as soon as that is forgotten; to forget it twice does no harm.
        waits = is_last & head.is_void & ~forgets.ready
        m.d.comb += [
            entry.eq(entries[answer.payload.tag]), given.index.eq(index), given.frame.eq(entry.frame),
            given.patch.eq(entry.patch), steps.valid.eq(answer.valid & ~head.is_lost & ~waits),
            forgets.valid.eq(answer.valid & (head.is_lost | (is_last & head.is_void))), forgets.payload.eq(entry.frame),
            ends.eq(Mux(head.is_lost, forgets.ready, steps.ready & is_last & ~waits)), answer.ready.eq(ends)]
        with m.If(steps.valid & steps.ready):
            m.d.sync += index.eq(index + 1)
        with m.If(answer.valid & head.is_lost & forgets.ready):
            m.d.sync += self.lost[1].eq(1)
        return Mux(answer.valid & ends, 1 << answer.payload.tag, 0)
